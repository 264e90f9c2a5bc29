"""Compiled assembly and products of the near field: blocks of six components in CSR.

A block ``(a, b)`` is ``int int N_a G N_b`` for the components 00 01 02 11 12 22 of the symmetric
kernel. Every test function owns its row: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def test_moments(
    span, first, values, weights, table_indptr, extraction, pairs, elements, moments,
    sources_indptr, sources, places, blocks,
):  # fmt: skip
    """Blocks of density functions of all pairs of elements, target elements ``first + span``.

    Parameters
    ----------
    values, weights : (n_table_rows, n_t), (n_elements, n_t) array
        Density functions and weights at the outer points.
    table_indptr, extraction :
        Table rows of each element and their Bernstein coefficients.
    pairs, elements, moments :
        Index pointer by outer point counted from ``first``; source element of each pair, increasing
        within a point; moments ``(n_pairs, 6 nb)``.
    sources_indptr, sources :
        Distinct source elements of each target element, counted from ``first``.
    places, blocks :
        Where the block of each pair of elements begins, ``(n_i n_j, 6)``; overwritten.
    """
    nt, width = weights.shape[1], moments.shape[1]
    nb, largest, longest = width // 6, 0, 0
    for e in range(table_indptr.size - 1):
        largest = max(largest, table_indptr[e + 1] - table_indptr[e])
    for e in range(span[0], span[1]):
        longest = max(longest, pairs[(e + 1) * nt] - pairs[e * nt])
    gathered, factors = np.empty(longest * width), np.empty(longest * largest)
    sums, applied = np.empty(width * largest), np.empty(6 * largest * largest)
    for e in range(span[0], span[1]):
        r0, ni = table_indptr[first + e], table_indptr[first + e + 1] - table_indptr[first + e]
        following = pairs[e * nt : (e + 1) * nt].copy()  # of each point, pairs by element
        for at in range(sources_indptr[e], sources_indptr[e + 1]):
            f, n = sources[at], 0
            for t in range(nt):
                while following[t] < pairs[e * nt + t + 1] and elements[following[t]] == f:
                    for c in range(width):
                        gathered[n * width + c] = moments[following[t], c]
                    for i in range(ni):
                        factors[n * ni + i] = values[r0 + i, t] * weights[first + e, t]
                    n += 1
                    following[t] += 1
            source = gathered[: n * width].reshape(n, width)
            tested = sums[: width * ni].reshape(width, ni)
            np.dot(source.T, factors[: n * ni].reshape(n, ni), tested)
            f0, nj = table_indptr[f], table_indptr[f + 1] - table_indptr[f]
            block = applied[: 6 * ni * nj].reshape(nj, 6 * ni)
            np.dot(extraction[f0 : f0 + nj], tested.reshape(nb, 6 * ni), block)
            for j in range(nj):
                for i in range(ni):
                    for c in range(6):
                        blocks[places[at] + i * nj + j, c] = block[j, c * ni + i]


@njit(cache=True, error_model="numpy", nogil=True)
def add_rows(
    span, rows, owner_indptr, owners, first, last, table_indptr, dofs, sources_indptr, sources,
    places, blocks, indptr, indices, data,
):  # fmt: skip
    """Add the `test_moments` blocks of target elements ``first:last`` to the rows they touch.

    Parameters
    ----------
    rows : (n_rows,) int array
        Test functions with support on these elements.
    owner_indptr, owners :
        Table rows of each test function, as ``(element, table row)`` pairs ``(n, 2)``.
    indptr, indices, data :
        The near field in CSR; ``data (nnz, 6)`` is added to.
    """
    place = np.empty(indptr.size - 1, np.int64)
    for row in range(span[0], span[1]):
        a = rows[row]
        for j in range(indptr[a], indptr[a + 1]):
            place[indices[j]] = j
        for o in range(owner_indptr[a], owner_indptr[a + 1]):
            e = owners[o, 0]
            if e < first or e >= last:
                continue
            i = owners[o, 1] - table_indptr[e]
            for at in range(sources_indptr[e - first], sources_indptr[e - first + 1]):
                f0, f1 = table_indptr[sources[at]], table_indptr[sources[at] + 1]
                begin = places[at] + i * (f1 - f0)
                for j in range(f1 - f0):
                    at_row = place[dofs[f0 + j]]
                    for c in range(6):
                        data[at_row, c] += blocks[begin + j, c]


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
