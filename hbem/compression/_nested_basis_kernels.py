"""Compiled nested bases of an H2-matrix: skeletons on proxy surfaces, sweeps up and down.

The points of a cluster, seen from a proxy surface, are replaced by a few of them:
``G(P, X) ~ G(P, X_skel) [1 T]`` with ``T = R_11^-1 R_12`` of a QR factorisation pivoted by points
(three columns at a time). Stresslets keep their normals and have skeletons of their own: forces on
a flat sheet cannot replace them. Every node writes its own values.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import kernel_line
from ._far_field_kernels import folded


@njit(cache=True, error_model="numpy", nogil=True)
def project_rows(A, q, c):
    """``c (3, w) = q (3, rows) A``, two rows a sweep."""
    c[:] = 0.0
    c0, c1, c2 = c[0], c[1], c[2]
    i = 0
    while i + 2 <= A.shape[0]:
        r, s = A[i], A[i + 1]
        q00, q10, q20 = q[0, i], q[1, i], q[2, i]
        q01, q11, q21 = q[0, i + 1], q[1, i + 1], q[2, i + 1]
        for k in range(r.size):
            c0[k] += q00 * r[k] + q01 * s[k]
            c1[k] += q10 * r[k] + q11 * s[k]
            c2[k] += q20 * r[k] + q21 * s[k]
        i += 2
    if i < A.shape[0]:
        r = A[i]
        q00, q10, q20 = q[0, i], q[1, i], q[2, i]
        for k in range(r.size):
            c0[k] += q00 * r[k]
            c1[k] += q10 * r[k]
            c2[k] += q20 * r[k]


@njit(cache=True, error_model="numpy", nogil=True)
def remove_rows(A, q, c, squares):
    """``A -= q^T c``, and the sums of squares of what is left by column."""
    squares[:] = 0.0
    c0, c1, c2 = c[0], c[1], c[2]
    for i in range(A.shape[0]):
        r = A[i]
        q0, q1, q2 = q[0, i], q[1, i], q[2, i]
        for k in range(r.size):
            value = r[k] - (q0 * c0[k] + q1 * c1[k] + q2 * c2[k])
            r[k] = value
            squares[k] += value * value


@njit(cache=True, error_model="numpy", nogil=True)
def orthonormal(A, j, n, q, floor):
    """Three columns of point j as orthonormal rows q; what vanishes becomes zero."""
    rows = A.shape[0]
    for a in range(3):
        line = q[a]
        for i in range(rows):
            line[i] = A[i, a * n + j]
        for b in range(a):
            d = np.dot(q[b], line)
            for i in range(rows):
                line[i] -= d * q[b, i]
        size = np.sqrt(np.dot(line, line))
        scale = A.dtype.type(1.0) / size if size > floor else A.dtype.type(0.0)
        for i in range(rows):
            line[i] *= scale


@njit(cache=True, error_model="numpy", nogil=True)
def skeleton(A, n, tolerance, pick, R):
    """Pivoted factorisation of ``A (rows, 3 n)``, destroyed; returns the number of points kept.

    ``pick (n,)`` receives the kept points in order, then the others; the leading 3 k rows of
    ``R (3 n, 3 n)`` the factors in the columns of A.
    """
    dtype = A.dtype
    w = 3 * n
    squares, q, free = np.zeros(w, dtype), np.empty((3, A.shape[0]), dtype), np.ones(n, np.bool_)
    for i in range(A.shape[0]):
        r = A[i]
        for k in range(w):
            squares[k] += r[k] * r[k]
    goal, k, largest = 0.0, 0, 0.0
    limit = min(n, A.shape[0] // 3)
    while k < limit:
        best, at = -1.0, -1
        for j in range(n):
            size = squares[j] + squares[n + j] + squares[2 * n + j]
            if free[j] and size > best:
                best, at = size, j
        if k == 0:
            largest = best
            goal = tolerance * tolerance * best
        if best <= goal:
            break
        orthonormal(A, at, n, q, 1e-14 * np.sqrt(largest))
        c = R[3 * k : 3 * k + 3]
        project_rows(A, q, c)
        remove_rows(A, q, c, squares)
        free[at] = False
        pick[k] = at
        k += 1
    rest = k
    for j in range(n):
        if free[j]:
            pick[rest] = j
            rest += 1
    return k


@njit(cache=True, error_model="numpy", nogil=True)
def interpolation(R, pick, k, n, T):
    """``T (3 k, 3 (n - k)) = R_11^-1 R_12``, components first on both sides."""
    m = n - k
    for r in range(3 * k):
        line = T[(r % 3) * k + r // 3]
        for c in range(3):
            for j in range(m):
                line[c * m + j] = R[r, c * n + pick[k + j]]
    size = 0.0
    for r in range(3 * k):
        size = max(size, abs(R[r, (r % 3) * n + pick[r // 3]]))
    for r in range(3 * k - 1, -1, -1):
        line = T[(r % 3) * k + r // 3]
        for s in range(r + 1, 3 * k):
            factor = R[r, (s % 3) * n + pick[s // 3]]
            other = T[(s % 3) * k + s // 3]
            for p in range(line.size):
                line[p] -= factor * other[p]
        diagonal = R[r, (r % 3) * n + pick[r // 3]]
        scale = R.dtype.type(0.0)
        if abs(diagonal) > 1e-14 * size:
            scale = R.dtype.type(1.0) / diagonal
        for p in range(line.size):
            line[p] *= scale


@njit(cache=True, error_model="numpy", nogil=True)
def level_skeletons(
    span, lower, upper, sphere, reach, positions, candidate_ptr, candidates, tolerance, counts,
    picks, slot_ptr, slots, normals,
):  # fmt: skip
    """Skeletons of all nodes of a level.

    Parameters
    ----------
    lower, upper : (n_nodes, 3) array
        Boxes of the nodes.
    sphere : (n_proxy, 3) array
        Unit vectors; the proxy surface is box plus ball of radius ``reach * diameter``.
    positions : (3, n_points) array
    candidate_ptr, candidates :
        Points by node.
    counts, picks :
        Results: points kept, and the order of the candidates.
    slot_ptr, slots :
        Room for the interpolations, ``9 n^2 / 4`` numbers a node.
    normals : (3, n_points) array
        For skeletons of stresslets, else ``(3, 0)``.
    """
    for node in range(span[0], span[1]):
        first, n = candidate_ptr[node], candidate_ptr[node + 1] - candidate_ptr[node]
        diameter = 0.0
        for c in range(3):
            diameter += (upper[node, c] - lower[node, c]) ** 2
        diameter = np.sqrt(diameter)
        x = np.empty((3, n), slots.dtype)
        middle = 0.5 * (lower[node] + upper[node])
        # distances in units of the diameter: single precision sees no absolute positions
        scale = 1.0 / diameter if diameter > 0.0 else 1.0
        for c in range(3):
            for j in range(n):
                x[c, j] = (positions[c, candidates[first + j]] - middle[c]) * scale
        A = np.empty((3 * sphere.shape[0], 3 * n), slots.dtype)
        p = np.empty(3, slots.dtype)
        one, zero = slots.dtype.type(1.0), slots.dtype.type(0.0)
        ny = np.empty((3, n if normals.shape[1] > 0 else 0), slots.dtype)
        for c in range(3):
            for j in range(ny.shape[1]):
                ny[c, j] = normals[c, candidates[first + j]]
        for i in range(sphere.shape[0]):
            for c in range(3):
                half = 0.5 * (upper[node, c] - lower[node, c]) * scale
                s = sphere[i, c]
                p[c] = half * min(1.0, max(-1.0, 1.8 * s)) + reach * s
            kernel_line(one, p, x, ny, zero, A[3 * i : 3 * i + 3])
        R = np.empty((min(3 * n, A.shape[0]), 3 * n), slots.dtype)
        k = skeleton(A, n, tolerance, picks[first : first + n], R)
        counts[node] = k
        room = slots[slot_ptr[node] : slot_ptr[node] + 9 * k * (n - k)]
        interpolation(R, picks[first : first + n], k, n, room.reshape(3 * k, 3 * (n - k)))


@njit(cache=True, error_model="numpy", nogil=True)
def up(span, starts, counts, kept, picks, pick_ptr, T_ptr, T, charges, skeleton_ptr, result):
    """Charges of the skeletons of a level: kept candidates plus ``T`` times the others.

    Node i takes the candidates ``starts[i] : starts[i] + counts[i]`` of ``charges (k, 3, n)`` and
    fills ``result`` from ``skeleton_ptr[i]``.
    """
    for i in range(span[0], span[1]):
        n, k = counts[i], kept[i]
        m = n - k
        pick = picks[pick_ptr[i] : pick_ptr[i] + n]
        matrix = T[T_ptr[i] : T_ptr[i] + 9 * k * m].reshape(3 * k, 3 * m)
        rest = np.empty(3 * m, charges.dtype)
        fold = 3 * m // 8
        sums = np.empty(fold, charges.dtype)
        for v in range(charges.shape[0]):
            for c in range(3):
                for j in range(m):
                    rest[c * m + j] = charges[v, c, starts[i] + pick[k + j]]
            for c in range(3):
                for j in range(k):
                    value = charges[v, c, starts[i] + pick[j]]
                    row = matrix[c * k + j]
                    value += folded(row, rest, fold, sums)
                    for p in range(8 * fold, 3 * m):
                        value += row[p] * rest[p]
                    result[v, c, skeleton_ptr[i] + j] = value


@njit(cache=True, error_model="numpy", nogil=True)
def down(
    span, starts, counts, kept, picks, pick_ptr, T_ptr, T, potentials, skeleton_ptr, skeletons
):
    """Add the potentials of the skeletons of a level to its candidates: the transpose of `up`."""
    for i in range(span[0], span[1]):
        n, k = counts[i], kept[i]
        m = n - k
        pick = picks[pick_ptr[i] : pick_ptr[i] + n]
        matrix = T[T_ptr[i] : T_ptr[i] + 9 * k * m].reshape(3 * k, 3 * m)
        rest = np.empty(3 * m, potentials.dtype)
        for v in range(potentials.shape[0]):
            rest[:] = 0.0
            for c in range(3):
                for j in range(k):
                    value = skeletons[v, c, skeleton_ptr[i] + j]
                    potentials[v, c, starts[i] + pick[j]] += value
                    row = matrix[c * k + j]
                    for p in range(3 * m):
                        rest[p] += value * row[p]
            for c in range(3):
                for j in range(m):
                    potentials[v, c, starts[i] + pick[k + j]] += rest[c * m + j]
