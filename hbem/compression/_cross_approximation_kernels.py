"""Compiled low-rank approximation of blocks of a plain Stokes kernel by cross approximation.

A block ``G(x_i, y_j)`` of 3x3 entries is reduced by whole points: rows of one target, columns of
one source, joined by the pseudo-inverse of their 3x3 entry, which may have any rank (that of the
double layer has rank one). Sampled rows, spread over the block and reduced along with it, prove
every stop: plain cross approximation stops by itself on coplanar and collinear clusters.
Vectors run over components first: entry ``c * n + j``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, kernel_line

SAMPLES = 6  # target points whose rows prove a stop
FAINT = 0.1  # targets whose approximate rows are below this share of the average are faint
KEPT = 1e-2  # singular values of a 3x3 pivot below this fraction of the largest are dropped


@njit(cache=True, error_model="numpy", nogil=True)
def subtract(line, coefficients, vectors, first, last):
    """``line -= sum_k coefficients[k] vectors[k]`` for k in first..last - 1, four a sweep."""
    k, n = first, line.size
    while k + 4 <= last:
        v0, v1, v2, v3 = vectors[k], vectors[k + 1], vectors[k + 2], vectors[k + 3]
        c0, c1, c2, c3 = (
            coefficients[k], coefficients[k + 1], coefficients[k + 2], coefficients[k + 3]
        )  # fmt: skip
        for j in range(n):
            line[j] -= c0 * v0[j] + c1 * v1[j] + (c2 * v2[j] + c3 * v3[j])
        k += 4
    while k < last:
        v, c = vectors[k], coefficients[k]
        for j in range(n):
            line[j] -= c * v[j]
        k += 1


@njit(cache=True, error_model="numpy", nogil=True)
def pivot(rows, scores, n):
    """Source with the largest 3x3 determinant, or the largest norm where all are singular."""
    a, b, c = rows[0], rows[1], rows[2]
    best, at, largest, where = -1.0, 0, -1.0, 0
    for j in range(n):
        p, q = n + j, 2 * n + j
        m0 = b[p] * c[q] - b[q] * c[p]
        m1 = b[j] * c[q] - b[q] * c[j]
        m2 = b[j] * c[p] - b[p] * c[j]
        det = abs(a[j] * m0 - a[p] * m1 + a[q] * m2)
        norm = a[j] ** 2 + a[p] ** 2 + a[q] ** 2 + b[j] ** 2 + b[p] ** 2 + b[q] ** 2
        norm += c[j] ** 2 + c[p] ** 2 + c[q] ** 2
        scores[j] = norm
        if det > best:
            best, at = det, j
        if norm > largest:
            largest, where = norm, j
    # a det of a tenth of its bound (norm / sqrt 3)^3 per unit of KEPT: the 3x3 entry is regular
    return at if best > KEPT * KEPT * (largest / 3.0) ** 1.5 else where


@njit(cache=True, error_model="numpy", nogil=True)
def square_sum(rows):
    total = 0.0
    for a in range(rows.shape[0]):
        line = np.ascontiguousarray(rows[a])  # it is already, but a part of an array hides that
        total += np.dot(line, line)
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def worst_sample(samples):
    """Index of the sampled target with the largest residual, and the sum over all."""
    worst, at, total = -1.0, 0, 0.0
    for k in range(samples.shape[0]):
        size = square_sum(samples[k])
        total += size
        if size > worst:
            worst, at = size, k
    return at, total


@njit(cache=True, error_model="numpy", nogil=True)
def cross(x, y, normals, tiny, tolerance, limit, seed, u, v, samples, scratch):
    """Cross approximation ``G ~ sum_k u[k] v[k]`` of one block; returns the rank or -1.

    Parameters
    ----------
    x, y : (3, m), (3, n) array
        Targets and sources; ``normals (3, n)`` or ``(3, 0)``.
    tolerance : float
        Relative to the Frobenius norm of the block.
    limit : int
        Rank beyond which the block counts as full: -1.
    u, v : (>= limit + 3, 3 m), (>= limit + 3, 3 n) array
    samples : (SAMPLES, 3, 3 n) array
    scratch : (7, 3 max(m, n)) array
    """
    m, n = x.shape[1], y.shape[1]
    rows, columns = scratch[:3, : 3 * n], scratch[3:6, : 3 * m]
    scores = scratch[6]
    count = min(SAMPLES, m)
    chosen = np.empty(count, np.int64)
    state = np.uint64(seed * 2 + 1)
    for k in range(count):
        # one draw from each stratum: the order within a cluster is spatial
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        low, high = k * m // count, (k + 1) * m // count
        chosen[k] = low + np.int64(state >> np.uint64(33)) % (high - low)
        kernel_line(OVER_8_PI, x[:, chosen[k]], y, normals, tiny, samples[k])
    samples = samples[:count]
    i, total = worst_sample(samples)
    i = chosen[i]
    visited = np.zeros(m, np.bool_)
    rank = 0
    lone = np.empty((3, min(1, normals.shape[1])))
    coefficients = np.empty(limit + 3)
    double = normals.shape[1] > 0
    if total == 0.0 and double:
        size = faint_samples(
            x, y, normals, tiny, seed, u, v, 0, coefficients, columns, lone, samples, chosen
        )
        total = size * n / m * count
        i = chosen[worst_sample(samples)[0]]
    if total == 0.0:
        return 0
    goal = tolerance * tolerance * total
    while True:
        visited[i] = True
        kernel_line(OVER_8_PI, x[:, i], y, normals, tiny, rows)
        for a in range(3):
            coefficients[:rank] = u[:rank, a * m + i]
            subtract(rows[a], coefficients, v, 0, rank)
        j = pivot(rows, scores, n)
        if scores[j] * n * count > 1e-6 * goal:
            for b in range(lone.shape[1]):
                lone[:, b] = -normals[:, j]
            kernel_line(OVER_8_PI, y[:, j], x, lone, tiny, columns)
            for b in range(3):
                coefficients[:rank] = v[:rank, b * n + j]
                subtract(columns[b], coefficients, u, 0, rank)
            entry = np.empty((3, 3))
            for a in range(3):
                for b in range(3):
                    entry[a, b] = rows[a, b * n + j]
            w, s, z = np.linalg.svd(entry)
            first = rank
            for k in range(3):
                if s[k] < KEPT * s[0]:
                    break
                c0, c1, c2 = z[k, 0] / s[k], z[k, 1] / s[k], z[k, 2] / s[k]
                for p in range(3 * m):
                    u[rank, p] = c0 * columns[0, p] + c1 * columns[1, p] + c2 * columns[2, p]
                for p in range(3 * n):
                    v[rank, p] = w[0, k] * rows[0, p] + w[1, k] * rows[1, p] + w[2, k] * rows[2, p]
                rank += 1
            for k in range(count):
                for a in range(3):
                    coefficients[:rank] = u[:rank, a * m + chosen[k]]
                    subtract(samples[k, a], coefficients, v, first, rank)
            step = square_sum(u[first:rank]) * square_sum(v[first:rank])
            worst, left = worst_sample(samples)
            if rank > limit:
                return -1
            small = step * count <= goal * m
        else:
            worst, left = worst_sample(samples)
            small = True
        if small and left <= goal and double:
            faint_samples(
                x, y, normals, tiny, seed + rank, u, v, rank, coefficients, columns, lone, samples,
                chosen,
            )  # fmt: skip
            worst, left = worst_sample(samples)
        if small and left <= goal:
            return rank
        i = next_target(columns, visited, m)
        if small and not visited[chosen[worst]]:
            i = chosen[worst]
        if i < 0:
            return -1


@njit(cache=True, error_model="numpy", nogil=True)
def faint_samples(
    x, y, normals, tiny, seed, u, v, rank, coefficients, columns, lone, samples, chosen
):
    """Residual rows of targets that the approximation hardly sees, in place of the samples.

    Coplanar sheets split a block of the double layer into parts that do not see each other: a
    part without a sample stays zero unnoticed. The odd samples are spread over the faint targets,
    the even ones are the faint targets with the largest residual under spread sources. Returns
    the mean square of the sampled columns.
    """
    m, n = x.shape[1], y.shape[1]
    weight = np.zeros(m)
    for k in range(rank):
        size = square_sum(v[k : k + 1])
        for i in range(m):
            weight[i] += size * (u[k, i] ** 2 + u[k, m + i] ** 2 + u[k, 2 * m + i] ** 2)
    faint = np.flatnonzero(weight <= FAINT * FAINT * weight.mean())
    count, total = samples.shape[0], 0.0
    samples[:] = 0.0
    if faint.size == 0:
        return total
    state = np.uint64(seed * 2 + 1)
    for k in range(count):
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        draw = np.int64(state >> np.uint64(33))
        low, high = k * faint.size // count, (k + 1) * faint.size // count
        chosen[k] = faint[low + draw % max(high - low, 1)]
        if k % 2 == 0:
            low, high = k * n // count, max((k + 1) * n // count, k * n // count + 1)
            j = low + draw % (high - low)
            for b in range(3):
                lone[b, 0] = -normals[b, j]
            kernel_line(OVER_8_PI, y[:, j], x, lone, tiny, columns)
            total += square_sum(columns) / ((count + 1) // 2)
            for b in range(3):
                coefficients[:rank] = v[:rank, b * n + j]
                subtract(columns[b], coefficients, u, 0, rank)
            chosen[k] = next_target(columns, weight > FAINT * FAINT * weight.mean(), m)
        kernel_line(OVER_8_PI, x[:, chosen[k]], y, normals, tiny, samples[k])
        for a in range(3):
            coefficients[:rank] = u[:rank, a * m + chosen[k]]
            subtract(samples[k, a], coefficients, v, 0, rank)
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def next_target(columns, visited, m):
    """The unvisited target with the largest residual in the last columns, -1 if none is left."""
    best, at = -1.0, -1
    for i in range(m):
        if not visited[i]:
            size = 0.0
            for b in range(3):
                size += columns[b, i] ** 2 + columns[b, m + i] ** 2 + columns[b, 2 * m + i] ** 2
            if size > best:
                best, at = size, i
    return at
