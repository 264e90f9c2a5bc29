"""Compiled assembly and products of the near field: blocks of six components in CSR.

A block ``(a, b)`` is ``int int N_a G N_b`` for the components 00 01 02 11 12 22 of the symmetric
kernel. Every test function owns its row: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def gather_moments(pairs, slots, moments, factors, start, local):
    """``local[slot] += w_t N_a(x_t) moments`` over the near pairs of one target element."""
    for t in range(factors.size):
        v = factors[t]
        for k in range(pairs[start + t], pairs[start + t + 1]):
            source, target = moments[k], local[slots[k]]
            for c in range(source.size):
                target[c] += v * source[c]


@njit(cache=True, error_model="numpy", nogil=True)
def scatter_functions(moments, tables, columns, place, data):
    """Add one element's moments, as density functions, to the blocks of one row."""
    nb = tables.shape[1]
    for row in range(columns.size):
        a0, a1, a2, a3, a4, a5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for b in range(nb):
            v = tables[row, b]
            a0 += v * moments[6 * b]
            a1 += v * moments[6 * b + 1]
            a2 += v * moments[6 * b + 2]
            a3 += v * moments[6 * b + 3]
            a4 += v * moments[6 * b + 4]
            a5 += v * moments[6 * b + 5]
        line = data[place[columns[row]]]
        line[0] += a0
        line[1] += a1
        line[2] += a2
        line[3] += a3
        line[4] += a4
        line[5] += a5


@njit(cache=True, error_model="numpy", nogil=True)
def add_rows(
    span, rows, owner_indptr, owners, first, last, values, weights, table_indptr, dofs, extraction,
    pairs, slots, moments, sources_indptr, sources, indptr, indices, data,
):  # fmt: skip
    """Add the near pairs of the target elements ``first:last`` to the rows that they touch.

    Parameters
    ----------
    rows : (n_rows,) int array
        Test functions with support on these elements.
    owner_indptr, owners :
        Table rows of each test function, as ``(element, table row)`` pairs ``(n, 2)``.
    values, weights : (n_table_rows, n_t), (n_elements, n_t) array
        Density functions and weights at the outer points.
    pairs, slots, moments :
        Index pointer by outer point counted from ``first``; position of each pair's source
        element among ``sources`` of its target element; moments ``(n_pairs, 6 nb)``.
    sources_indptr, sources :
        Distinct source elements of each target element, counted from ``first``.
    indptr, indices, data :
        The near field in CSR; ``data (nnz, 6)`` is added to.
    """
    nt = weights.shape[1]
    n = indptr.size - 1
    widest = 0
    for e in range(last - first):
        widest = max(widest, sources_indptr[e + 1] - sources_indptr[e])
    for i in range(span[0], span[1]):
        a = rows[i]
        place = np.empty(n, np.int64)
        for j in range(indptr[a], indptr[a + 1]):
            place[indices[j]] = j
        local = np.empty((widest, moments.shape[1]))
        factors = np.empty(nt)
        for o in range(owner_indptr[a], owner_indptr[a + 1]):
            e, row = owners[o, 0], owners[o, 1]
            if e < first or e >= last:
                continue
            local[:] = 0.0
            for t in range(nt):
                factors[t] = values[row, t] * weights[e, t]
            gather_moments(pairs, slots, moments, factors, (e - first) * nt, local)
            begin = sources_indptr[e - first]
            for k in range(begin, sources_indptr[e - first + 1]):
                f = sources[k]
                r0, r1 = table_indptr[f], table_indptr[f + 1]
                scatter_functions(local[k - begin], extraction[r0:r1], dofs[r0:r1], place, data)


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def multiply(span, indptr, indices, data, x, y):
    """``y += A x`` for ``x (n_columns, 3, k)``, ``y (n_rows, 3, k)``."""
    for a in range(span[0], span[1]):
        for k in range(x.shape[2]):
            u0, u1, u2 = 0.0, 0.0, 0.0
            for j in range(indptr[a], indptr[a + 1]):
                s, b = data[j], indices[j]
                v0, v1, v2 = x[b, 0, k], x[b, 1, k], x[b, 2, k]
                u0 += s[0] * v0 + s[1] * v1 + s[2] * v2
                u1 += s[1] * v0 + s[3] * v1 + s[4] * v2
                u2 += s[2] * v0 + s[4] * v1 + s[5] * v2
            y[a, 0, k] += u0
            y[a, 1, k] += u1
            y[a, 2, k] += u2
