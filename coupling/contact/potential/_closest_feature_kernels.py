"""Compiled search for the triangles that face a sample of the same sheet or of another one."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def closest_on_triangle(p, a, b, c, weights):
    """Closest point of a triangle to ``p``: its squared distance; ``weights (3,)`` are filled.

    Weights of corners that do not span the closest feature are exactly 0
    [Ericson, Real-Time Collision Detection, 5.1.5].
    """
    d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        u, v = b[k] - a[k], c[k] - a[k]
        d1 += u * (p[k] - a[k])
        d2 += v * (p[k] - a[k])
        d3 += u * (p[k] - b[k])
        d4 += v * (p[k] - b[k])
        d5 += u * (p[k] - c[k])
        d6 += v * (p[k] - c[k])
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
        r = p[k] - weights[0] * a[k] - weights[1] * b[k] - weights[2] * c[k]
        square += r * r
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
    order, fill = np.empty(n, np.int64), start[:-1].copy()
    for i in range(n):
        order[fill[cell[i]]] = i
        fill[cell[i]] += 1
    return start, order


@njit(cache=True, error_model="numpy", nogil=True)
def near_triangles(points, triangles, reach, low, width, counts):
    """Triangles within ``reach`` of each point, without those it is a corner of.

    A regular grid of the points serves each triangle's box. Returns the first place of each
    point ``(n + 1,)`` in the list of triangles, and the list.
    """
    n = len(points)
    start, order = sort_into_cells(points, low, width, counts, np.empty(n, np.int64))
    pairs, found = np.empty((16 * n + 64, 2), np.int32), 0
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    lower, upper, weights = np.empty(3), np.empty(3), np.empty(3)
    for t in range(len(triangles)):
        ta, tb, tc = triangles[t]
        a, b, c = points[ta], points[tb], points[tc]
        for k in range(3):
            lower[k] = min(a[k], b[k], c[k]) - reach
            upper[k] = max(a[k], b[k], c[k]) + reach
            first[k] = min(max(int((lower[k] - low[k]) / width), 0), counts[k] - 1)
            last[k] = min(max(int((upper[k] - low[k]) / width), 0), counts[k] - 1)
        for x in range(first[0], last[0] + 1):
            for y in range(first[1], last[1] + 1):
                row = (x * counts[1] + y) * counts[2]
                for place in range(start[row + first[2]], start[row + last[2] + 1]):
                    i = order[place]
                    p = points[i]
                    if i in (ta, tb, tc):
                        continue
                    if (
                        p[0] < lower[0] or p[0] > upper[0]
                        or p[1] < lower[1] or p[1] > upper[1]
                        or p[2] < lower[2] or p[2] > upper[2]
                    ):  # fmt: skip
                        continue
                    if closest_on_triangle(p, a, b, c, weights) > reach * reach:
                        continue
                    if found == len(pairs):
                        more = np.empty((2 * found, 2), np.int32)
                        more[:found] = pairs
                        pairs = more
                    pairs[found, 0], pairs[found, 1] = i, t
                    found += 1
    begin = np.zeros(n + 1, np.int64)
    for j in range(found):
        begin[pairs[j, 0] + 1] += 1
    for i in range(n):
        begin[i + 1] += begin[i]
    listed, fill = np.empty(found, np.int32), begin[:-1].copy()
    for j in range(found):
        listed[fill[pairs[j, 0]]] = pairs[j, 1]
        fill[pairs[j, 0]] += 1
    return begin, listed


@njit(cache=True, error_model="numpy", nogil=True)
def normals_of(points, triangles):
    """Unit normals of triangles and of their vertices, weighted by area; 0 where there is none."""
    faces, nodes = np.empty((len(triangles), 3)), np.zeros((len(points), 3))
    for t in range(len(triangles)):
        ta, tb, tc = triangles[t]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            faces[t, k] = (points[tb, i] - points[ta, i]) * (points[tc, j] - points[ta, j]) - (
                points[tb, j] - points[ta, j]
            ) * (points[tc, i] - points[ta, i])
        for k in range(3):
            nodes[ta, k] += faces[t, k]
            nodes[tb, k] += faces[t, k]
            nodes[tc, k] += faces[t, k]
    for normals in (faces, nodes):
        for t in range(len(normals)):
            size = np.sqrt(normals[t, 0] ** 2 + normals[t, 1] ** 2 + normals[t, 2] ** 2)
            if size > 0.0:
                for k in range(3):
                    normals[t, k] /= size
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
        p = points[i]
        best[:] = reach * reach
        for place in range(begin[i], begin[i + 1]):
            t = listed[place]
            cosine = 0.0
            for k in range(3):
                cosine += nodes[i, k] * faces[t, k]
            if not cosine < opposing:
                continue
            ta, tb, tc = triangles[t]
            square = closest_on_triangle(p, points[ta], points[tb], points[tc], trial)
            if square >= best[0] and square >= best[1]:
                continue
            own, other = 0.0, 0.0
            for k in range(3):
                y = trial[0] * points[ta, k] + trial[1] * points[tb, k] + trial[2] * points[tc, k]
                own += (p[k] - y) * nodes[i, k]
                other += (p[k] - y) * faces[t, k]
            if own < 0.0 and other > 0.0:
                side = 0
            elif own > 0.0 and other < 0.0:
                side = 1
            else:
                continue
            if square < best[side]:
                best[side] = square
                chosen[i, side] = t
                weights[i, side] = trial
    return chosen, weights
