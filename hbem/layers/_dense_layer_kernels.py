"""Compiled dense assembly of the plain part of the single layer.

``B^T W G W B`` with the density functions B at quadrature points, their weights W and the
Stokeslet G: one target element at a time, targets contiguous, so that every inner loop is a plain
vector operation; then test functions, one density function at a time. Each target element and each
function writes its own rows: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet_components


@njit(cache=True, error_model="numpy", nogil=True)
def add_sources(values, kernels, line):
    """``line += values @ kernels``, four sources a sweep to spare memory traffic."""
    n, q = values.size, 0
    while q + 4 <= n:
        v0, v1, v2, v3 = values[q], values[q + 1], values[q + 2], values[q + 3]
        k0, k1, k2, k3 = kernels[q], kernels[q + 1], kernels[q + 2], kernels[q + 3]
        for c in range(line.size):
            line[c] += v0 * k0[c] + v1 * k1[c] + (v2 * k2[c] + v3 * k3[c])
        q += 4
    while q < n:
        v, k = values[q], kernels[q]
        for c in range(line.size):
            line[c] += v * k[c]
        q += 1


@njit(cache=True, error_model="numpy", nogil=True)
def source_columns(span, targets, sources, weights, values, table_indptr, dofs, tiny, columns):
    """Potentials of every density function at the points of some target elements.

    Parameters
    ----------
    targets : (n_targets, 3, n_t) array
    sources, weights : (n_elements, n_q, 3), (n_elements, n_q) array
    values : (n_rows, n_q) array
        Density functions at the source points, by table row.
    columns : (n_targets, n_dofs, 6 * n_t) array
        Result, overwritten.
    """
    nt, nq = targets.shape[2], sources.shape[1]
    for e in range(span[0], span[1]):
        kernel = np.empty((nq, 6, nt))
        flat = kernel.reshape(nq, 6 * nt)
        out = columns[e]
        out[:] = 0.0
        for f in range(sources.shape[0]):
            for q in range(nq):
                strength = OVER_8_PI * weights[f, q]
                stokeslet_components(strength, targets[e], sources[f, q], tiny, kernel[q])
            for row in range(table_indptr[f], table_indptr[f + 1]):
                add_sources(values[row], flat, out[dofs[row]])


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def test_rows(span, columns, weights, values, table_indptr, dofs, first, matrix):
    """Add ``sum_t w_t N_a(x_t) columns`` of some target elements to the matrix.

    Parameters
    ----------
    columns : (n_targets, n_dofs, 6 * n_t) array
    weights : (n_elements, n_t) array
    values : (n_rows, n_t) array
        Density functions at the outer points, by table row.
    first : int
        Element number of the first target element.
    matrix : (n_dofs, n_dofs, 6) array
        Source function, test function, component.
    """
    nt = weights.shape[1]
    for b in range(span[0], span[1]):
        for e in range(columns.shape[0]):
            line = columns[e, b]
            for row in range(table_indptr[first + e], table_indptr[first + e + 1]):
                a = dofs[row]
                a0, a1, a2, a3, a4, a5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                for t in range(nt):
                    v = values[row, t] * weights[first + e, t]
                    a0 += v * line[t]
                    a1 += v * line[nt + t]
                    a2 += v * line[2 * nt + t]
                    a3 += v * line[3 * nt + t]
                    a4 += v * line[4 * nt + t]
                    a5 += v * line[5 * nt + t]
                matrix[b, a, 0] += a0
                matrix[b, a, 1] += a1
                matrix[b, a, 2] += a2
                matrix[b, a, 3] += a3
                matrix[b, a, 4] += a4
                matrix[b, a, 5] += a5
