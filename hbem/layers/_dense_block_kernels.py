"""Compiled dense blocks of the plain far operator ``B^T W G W B`` between some density functions.

B are the density functions at quadrature points, W their weights, G the Stokeslet. Element by
element as in the dense assembly: targets contiguous, source functions one at a time. G is
symmetric, so where both sides use the same points half of the pairs suffice.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet_components
from ._dense_layer_kernels import add_sources


@njit(cache=True, error_model="numpy", nogil=True)
def add_tests(columns, used, values, weights, local, nt, mirror, block):
    """Test the columns of one target element; ``mirror`` adds the transposed pairs too."""
    for r in range(local.size):
        a = local[r]
        if a < 0:
            continue
        for b in range(columns.shape[0]):
            if not used[b]:
                continue
            line = columns[b]
            a0, a1, a2, a3, a4, a5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for t in range(nt):
                v = values[r, t] * weights[t]
                a0 += v * line[t]
                a1 += v * line[nt + t]
                a2 += v * line[2 * nt + t]
                a3 += v * line[3 * nt + t]
                a4 += v * line[4 * nt + t]
                a5 += v * line[5 * nt + t]
            for side in range(2 if mirror else 1):
                target = block[a, b] if side == 0 else block[b, a]
                target[0] += a0
                target[1] += a1
                target[2] += a2
                target[3] += a3
                target[4] += a4
                target[5] += a5


@njit(cache=True, error_model="numpy", nogil=True)
def plain_block(
    elements, targets, outer_weights, outer_values, sources, weights, values, table_indptr, local,
    same, tiny, block,
):  # fmt: skip
    """Add the plain operator between the functions of one patch.

    Parameters
    ----------
    elements : (m,) int array
        Elements that carry these functions.
    targets : (n_elements, 3, n_t) array
    outer_weights : (n_elements, n_t) array
    outer_values, values : (n_rows, n_t), (n_rows, n_q) array
        Density functions at outer and source points, by table row.
    sources, weights : (n_elements, n_q, 3), (n_elements, n_q) array
    local : (n_rows,) int array
        Position of each table row's function within the block, -1 outside.
    same : bool
        Outer and source points are the same.
    block : (n, n, 6) array
        Test function, source function, component; added to.
    """
    nt, nq = targets.shape[2], sources.shape[1]
    kernel = np.empty((nq, 6, nt))
    flat = kernel.reshape(nq, 6 * nt)
    columns = np.empty((block.shape[0], 6 * nt))
    used = np.empty(block.shape[0], np.bool_)
    for i in range(elements.size):
        e = elements[i]
        rows = slice(table_indptr[e], table_indptr[e + 1])
        # pass 0: the element with itself (or with all); pass 1: with those after it
        for sweep in range(2 if same else 1):
            columns[:] = 0.0
            used[:] = False
            first, last = 0, elements.size
            if same:
                first, last = (i, i + 1) if sweep == 0 else (i + 1, elements.size)
            for j in range(first, last):
                f = elements[j]
                for q in range(nq):
                    strength = OVER_8_PI * weights[f, q]
                    stokeslet_components(strength, targets[e], sources[f, q], tiny, kernel[q])
                for row in range(table_indptr[f], table_indptr[f + 1]):
                    b = local[row]
                    if b >= 0:
                        used[b] = True
                        add_sources(values[row], flat, columns[b])
            add_tests(
                columns, used, outer_values[rows], outer_weights[e], local[rows], nt, sweep == 1,
                block,
            )  # fmt: skip
