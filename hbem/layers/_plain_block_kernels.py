"""Compiled entries of the plain operator ``B^T W G W B`` between density functions.

Targets stand in the lanes of the processor, `LANES` of them in one sweep over source elements;
their functions' sums are small matrix products, which reach the speed of BLAS. Where outer and
source points are the same, G is symmetric: only sources from the sweep's own targets on are
taken, its own with half their weight, and what is summed is S of ``S + S^T``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet

LANES = 32  # targets of one sweep: with the kernels of nine sources they stay in the first cache


@njit(cache=True, error_model="numpy", nogil=True)
def tested_targets(first, weights, indptr, indices, values, position):
    """Functions at the targets of a sweep, and their weighted values ``(LANES, n)``."""
    last = min(first + LANES, weights.size)
    begin, end = indptr[first], indptr[last]
    tested, count = np.empty(end - begin, np.int64), 0
    for k in range(begin, end):
        position[indices[k]] = -1
    for k in range(begin, end):
        if position[indices[k]] < 0:
            position[indices[k]], tested[count] = count, indices[k]
            count += 1
    table = np.zeros((LANES, count))
    for t in range(first, last):
        for k in range(indptr[t], indptr[t + 1]):
            table[t - first, position[indices[k]]] += weights[t] * values[k]
    return tested[:count], table


@njit(cache=True, error_model="numpy", nogil=True)
def element_kernels(x, sources, strengths, tiny, kernels):
    """Components 00 01 02 11 12 22 between all targets ``(3, LANES)`` and some sources."""
    x0, x1, x2 = x[0], x[1], x[2]
    for q in range(strengths.size):
        y0, y1, y2, strength = sources[q, 0], sources[q, 1], sources[q, 2], strengths[q]
        k = kernels[q]
        for t in range(LANES):
            r0, r1, r2 = x0[t] - y0, x1[t] - y1, x2[t] - y2
            a, b = stokeslet(strength, r0, r1, r2, tiny)
            k[0, t] = a + b * r0 * r0
            k[1, t] = b * r0 * r1
            k[2, t] = b * r0 * r2
            k[3, t] = a + b * r1 * r1
            k[4, t] = b * r1 * r2
            k[5, t] = a + b * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def tested_sums(
    targets, target_weights, test_indptr, test_indices, test_values, sources, weights, values,
    table_indptr, dofs, n_dofs, same, tiny, first, elements, functions,
):  # fmt: skip
    """Entries of the functions at one sweep's targets with those of some source elements.

    Parameters
    ----------
    targets, target_weights : (n_targets, 3), (n_targets,) array
    test_indptr, test_indices, test_values : arrays
        Density functions at the targets, CSR.
    sources, weights : (n_elements, n_q, 3), (n_elements, n_q) array
    values : (n_rows, n_q) array
        Density functions at the source points, by table row.
    same : bool
        Outer and source points are the same.
    first : int
        Number of the sweep's first target.
    elements, functions : (m,), (n,) int array
        Source elements, increasing, and the functions whose sums are wanted.

    Returns
    -------
    tested : (n_tested,) int array
        Functions at the targets.
    used : (n_used,) int array
        Functions of the sources.
    sums : (6 n_used, n_tested) array
        By function of the sources and component.
    """
    position = np.empty(n_dofs, np.int64)
    tested, table = tested_targets(
        first, target_weights, test_indptr, test_indices, test_values, position
    )
    x = np.empty((3, LANES))
    for t in range(LANES):
        for c in range(3):
            x[c, t] = targets[min(first + t, targets.shape[0] - 1), c]
    nq = sources.shape[1]
    kernels, strengths = np.empty((nq, 6, LANES)), np.empty(nq)
    flat = kernels.reshape(nq, 6 * LANES)
    most = 0
    for f in elements:
        most = max(most, table_indptr[f + 1] - table_indptr[f])
    potentials = np.empty((most, 6 * LANES))
    columns = np.empty((functions.size, 6 * LANES))
    lines = columns.reshape(6 * functions.size, LANES)
    used, count = np.empty(functions.size, np.int64), 0
    for k in range(n_dofs):
        position[k] = -2  # not wanted
    for k in functions:
        position[k] = -1  # not met yet
    for f in elements:
        if same and (f + 1) * nq <= first:
            continue
        for q in range(nq):
            ahead = f * nq + q - first
            share = 1.0 if not same or ahead >= LANES else (0.5 if ahead >= 0 else 0.0)
            strengths[q] = share * OVER_8_PI * weights[f, q]
        element_kernels(x, sources[f], strengths, tiny, kernels)
        begin, end = table_indptr[f], table_indptr[f + 1]
        np.dot(values[begin:end], flat, potentials[: end - begin])
        for row in range(begin, end):
            b, line = position[dofs[row]], potentials[row - begin]
            if b == -1:
                position[dofs[row]], used[count] = count, dofs[row]
                column = columns[count]
                for c in range(6 * LANES):
                    column[c] = line[c]
                count += 1
            elif b >= 0:
                column = columns[b]
                for c in range(6 * LANES):
                    column[c] += line[c]
    sums = np.empty((6 * count, tested.size))
    np.dot(lines[: 6 * count], table, sums)
    return tested, used[:count], sums


@njit(cache=True, error_model="numpy", nogil=True)
def add_sums(tested, used, sums, indptr, indices, data):
    """Add the sums of a sweep to the entries ``data (nnz, 6)`` of a pattern in CSR."""
    slot = np.zeros(indptr.size - 1, np.int64)
    for j in range(tested.size):
        begin, end = indptr[tested[j]], indptr[tested[j] + 1]
        for k in range(begin, end):
            slot[indices[k]] = k + 1
        for b in range(used.size):
            k = slot[used[b]] - 1
            if begin <= k < end:  # others are left from the rows before
                for c in range(6):
                    data[k, c] += sums[6 * b + c, j]


@njit(cache=True, error_model="numpy", nogil=True)
def add_block(functions, indptr, indices, data, mirror, block):
    """Add the entries between some functions to their matrix ``(3 n, 3 n)``.

    With ``mirror`` the transposed entries too.
    """
    position = np.zeros(indptr.size - 1, np.int64)
    for i in range(functions.size):
        position[functions[i]] = i + 1
    for i in range(functions.size):
        for k in range(indptr[functions[i]], indptr[functions[i] + 1]):
            j = position[indices[k]] - 1
            if j < 0:
                continue
            for side in range(2 if mirror else 1):
                r, s = (3 * i, 3 * j) if side == 0 else (3 * j, 3 * i)
                block[r, s] += data[k, 0]
                block[r, s + 1] += data[k, 1]
                block[r, s + 2] += data[k, 2]
                block[r + 1, s] += data[k, 1]
                block[r + 1, s + 1] += data[k, 3]
                block[r + 1, s + 2] += data[k, 4]
                block[r + 2, s] += data[k, 2]
                block[r + 2, s + 1] += data[k, 4]
                block[r + 2, s + 2] += data[k, 5]
