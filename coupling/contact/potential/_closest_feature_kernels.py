"""Compiled search for the triangles that face a sample of the same sheet or of another one."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def closest_on_triangle(points, i, a, b, c, weights):
    """Closest point of the triangle a, b, c to point i: its squared distance and ``weights (3,)``.

    Weights of corners that do not span the closest feature are exactly 0
    [Ericson, Real-Time Collision Detection, 5.1.5].
    """
    d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        pa, pb, pc = points[a, k], points[b, k], points[c, k]
        u, v, x = pb - pa, pc - pa, points[i, k]
        d1 += u * (x - pa)
        d2 += v * (x - pa)
        d3 += u * (x - pb)
        d4 += v * (x - pb)
        d5 += u * (x - pc)
        d6 += v * (x - pc)
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if d1 <= 0.0 and d2 <= 0.0:
        w1, w2 = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        w1, w2 = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        w1, w2 = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        w1, w2 = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w1, w2 = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        w2 = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        w1 = 1.0 - w2
    else:
        w1, w2 = vb / (va + vb + vc), vc / (va + vb + vc)
    weights[0], weights[1], weights[2] = 1.0 - w1 - w2, w1, w2
    if va <= 0.0 and w1 + w2 > 0.0 and weights[0] < 1e-12:
        weights[0] = 0.0  # on the edge b c, where 1 - w1 - w2 leaves a rounding error
    square = 0.0
    for k in range(3):
        y = weights[0] * points[a, k] + weights[1] * points[b, k] + weights[2] * points[c, k]
        square += (points[i, k] - y) ** 2
    return square


@njit(cache=True, error_model="numpy", nogil=True)
def sort_into_cells(points, low, width, counts, cell):
    """First place of each grid cell ``(n_cells + 1,)`` and the points in order of their cells."""
    n = len(points)
    start = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    for i in range(n):
        index = 0
        for k in range(3):
            place = int((points[i, k] - low[k]) / width)
            index = index * counts[k] + min(max(place, 0), counts[k] - 1)
        cell[i] = index
        start[index + 1] += 1
    for j in range(len(start) - 1):
        start[j + 1] += start[j]
    order, fill = np.empty(n, np.int64), start.copy()
    for i in range(n):
        order[fill[cell[i]]] = i
        fill[cell[i]] += 1
    return start, order


@njit(cache=True, error_model="numpy", nogil=True)
def near_pairs(points, triangles, reach, low, width, counts, start, order, pairs):
    """Points within ``reach`` of each triangle, without its corners, as ``pairs (most, 2)``.

    A regular grid of the points (`sort_into_cells`) serves each triangle's box. Returns how many
    there are, of which the first ones have found a place.
    """
    found, weights, lower, upper = 0, np.empty(3), np.empty(3), np.empty(3)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            lower[k] = min(points[a, k], points[b, k], points[c, k]) - reach
            upper[k] = max(points[a, k], points[b, k], points[c, k]) + reach
            first[k] = min(max(int((lower[k] - low[k]) / width), 0), counts[k] - 1)
            last[k] = min(max(int((upper[k] - low[k]) / width), 0), counts[k] - 1)
        for x in range(first[0], last[0] + 1):
            for y in range(first[1], last[1] + 1):
                row = (x * counts[1] + y) * counts[2]
                for place in range(start[row + first[2]], start[row + last[2] + 1]):
                    i = order[place]
                    inside = i not in (a, b, c)
                    for k in range(3):
                        inside = inside and lower[k] <= points[i, k] <= upper[k]
                    if not inside:
                        continue
                    if closest_on_triangle(points, i, a, b, c, weights) > reach * reach:
                        continue
                    if found < len(pairs):
                        pairs[found, 0], pairs[found, 1] = i, t
                    found += 1
    return found


@njit(cache=True, error_model="numpy", nogil=True)
def by_point(pairs, n):
    """First place of each point ``(n + 1,)`` in a list of its triangles, and the list."""
    begin = np.zeros(n + 1, np.int64)
    for j in range(len(pairs)):
        begin[pairs[j, 0] + 1] += 1
    for i in range(n):
        begin[i + 1] += begin[i]
    listed, fill = np.empty(len(pairs), np.int32), begin.copy()
    for j in range(len(pairs)):
        i = pairs[j, 0]
        listed[fill[i]] = pairs[j, 1]
        fill[i] += 1
    return begin, listed


@njit(cache=True, error_model="numpy", nogil=True)
def make_unit(normals):
    """Vectors ``(n, 3)`` scaled to length 1; 0 stays."""
    for t in range(len(normals)):
        size = np.sqrt(normals[t, 0] ** 2 + normals[t, 1] ** 2 + normals[t, 2] ** 2)
        if size > 0.0:
            for k in range(3):
                normals[t, k] /= size


@njit(cache=True, error_model="numpy", nogil=True)
def normals_of(points, triangles):
    """Unit normals of triangles and of their vertices, weighted by area; 0 where there is none."""
    faces, nodes = np.empty((len(triangles), 3)), np.zeros((len(points), 3))
    for t in range(len(triangles)):
        ta, tb, tc = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            faces[t, k] = (points[tb, i] - points[ta, i]) * (points[tc, j] - points[ta, j]) - (
                points[tb, j] - points[ta, j]
            ) * (points[tc, i] - points[ta, i])
        for k in range(3):
            nodes[ta, k] += faces[t, k]
            nodes[tb, k] += faces[t, k]
            nodes[tc, k] += faces[t, k]
    make_unit(faces)
    make_unit(nodes)
    return faces, nodes


@njit(cache=True, error_model="numpy", nogil=True)
def facing_features(points, triangles, begin, listed, reach, opposing):
    """Closest point within ``reach`` on an opposing triangle, of each point and each side.

    Side 0 is outside, where the sheets turn their outward normals at each other, side 1 inside.
    Returns triangles ``(n, 2)``, -1 where there is none, and their corners' weights ``(n, 2, 3)``.
    """
    faces, nodes = normals_of(points, triangles)
    n = len(points)
    chosen, weights = np.full((n, 2), -1, np.int32), np.zeros((n, 2, 3))
    best, trial = np.empty(2), np.empty(3)
    for i in range(n):
        best[0], best[1] = reach * reach, reach * reach
        for place in range(begin[i], begin[i + 1]):
            t = listed[place]
            cosine = 0.0
            for k in range(3):
                cosine += nodes[i, k] * faces[t, k]
            if not cosine < opposing:
                continue
            ta, tb, tc = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            square = closest_on_triangle(points, i, ta, tb, tc, trial)
            if square >= best[0] and square >= best[1]:
                continue
            own, other = 0.0, 0.0
            for k in range(3):
                y = trial[0] * points[ta, k] + trial[1] * points[tb, k] + trial[2] * points[tc, k]
                own += (points[i, k] - y) * nodes[i, k]
                other += (points[i, k] - y) * faces[t, k]
            if own < 0.0 and other > 0.0:
                side = 0
            elif own > 0.0 and other < 0.0:
                side = 1
            else:
                continue
            if square < best[side]:
                best[side] = square
                chosen[i, side] = t
                for k in range(3):
                    weights[i, side, k] = trial[k]
    return chosen, weights
