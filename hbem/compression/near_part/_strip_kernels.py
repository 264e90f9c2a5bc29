"""Compiled near part of an H2-matrix on density functions, one strip a leaf.

The strip of a leaf holds the functions of all its partners against its own: kernel values between
points, summed to the functions of the sources, then tested, as matrix products. Scratch is
allocated once a call: fresh memory for every pair of leaves took longer than the products.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..._stokes_kernels import OVER_8_PI, stokeslet_components, stresslet_components

LANES = 8  # target counts are padded to multiples: no scalar tails


@njit(cache=True, error_model="numpy", nogil=True)
def near_strips(
    span, begin, positions, normals, tiny, t_point_ptr, t_points, t_item_ptr, t_dense_ptr, t_dense,
    s_point_ptr, s_points, s_item_ptr, s_items, s_dense_ptr, s_dense, partner_ptr, partners, halved,
    strip_ptr, strips, strip_at, data,
):  # fmt: skip
    """Strips of the leaves ``begin + span``; see `stored_near.LeafFunctions` for their functions.

    Parameters
    ----------
    partner_ptr, partners :
        Source leaves of each leaf; ``halved``: half of itself.
    strip_ptr, strips :
        Functions of all partners of a leaf, increasing.
    strip_at, data :
        Results from ``data[strip_at[leaf - begin]]``, ``(n_strip, 6, n_items)`` each.
    """
    m, q = np.diff(t_point_ptr).max() + LANES, np.diff(s_point_ptr).max()
    kernels = np.empty(q * 6 * m, data.dtype)
    sums = np.empty(np.diff(s_item_ptr).max() * 6 * m, data.dtype)
    potentials = np.empty(np.diff(strip_ptr).max() * 6 * m, data.dtype)
    y, normal = np.empty(3), np.empty(min(3, 3 * normals.shape[1]))
    half, one = data.dtype.type(0.5), data.dtype.type(1.0)
    for t in range(begin + span[0], begin + span[1]):
        pt = t_points[t_point_ptr[t] : t_point_ptr[t + 1]]
        strip = strips[strip_ptr[t] : strip_ptr[t + 1]]
        nt, padded = t_item_ptr[t + 1] - t_item_ptr[t], (pt.size + LANES - 1) // LANES * LANES
        if nt == 0 or strip.size == 0:
            continue
        width = 6 * padded
        x, tests = np.empty((3, padded)), np.zeros((padded, nt), data.dtype)
        tests[: pt.size] = t_dense[t_dense_ptr[t] : t_dense_ptr[t + 1]].reshape(pt.size, nt)
        for i in range(padded):
            for c in range(3):
                x[c, i] = positions[c, pt[min(i, pt.size - 1)]]
        potential = potentials[: strip.size * width].reshape(strip.size, width)
        potential[:] = 0.0
        for k in range(partner_ptr[t], partner_ptr[t + 1]):
            s = partners[k]
            ps = s_points[s_point_ptr[s] : s_point_ptr[s + 1]]
            items = s_items[s_item_ptr[s] : s_item_ptr[s + 1]]
            if items.size == 0:
                continue
            kernel = kernels[: ps.size * width].reshape(ps.size, 6, padded)
            for j in range(ps.size):
                for c in range(3):
                    y[c] = positions[c, ps[j]]
                for c in range(normal.size):
                    normal[c] = normals[c, ps[j]]
                if normal.size == 0:
                    stokeslet_components(OVER_8_PI, x, y, tiny, kernel[j])
                else:
                    stresslet_components(OVER_8_PI, x, y, normal, tiny, kernel[j])
            basis = s_dense[s_dense_ptr[s] : s_dense_ptr[s + 1]].reshape(ps.size, items.size)
            part = sums[: items.size * width].reshape(items.size, width)
            np.dot(basis.T, kernels[: ps.size * width].reshape(ps.size, width), part)
            weight, u = half if halved and s == t else one, 0
            for b in range(items.size):
                while strip[u] != items[b]:
                    u += 1
                line, more = potential[u], part[b]
                for p in range(width):
                    line[p] += weight * more[p]
        size = strip.size * 6 * nt
        out = data[strip_at[t - begin] : strip_at[t - begin] + size].reshape(6 * strip.size, nt)
        np.dot(potential.reshape(6 * strip.size, padded), tests, out)


@njit(cache=True, error_model="numpy", nogil=True)
def add_strips(
    begin, end, item_ptr, items, strip_ptr, strips, strip_at, data, indptr, indices, out
):
    """Add the strips of leaves ``begin : end`` to a sparse matrix of functions, ``(nnz, 6)``."""
    for t in range(begin, end):
        nt = item_ptr[t + 1] - item_ptr[t]
        start = strip_at[t - begin]
        for a in range(nt):
            k = indptr[items[item_ptr[t] + a]]
            for u in range(strip_ptr[t + 1] - strip_ptr[t]):
                while indices[k] != strips[strip_ptr[t] + u]:
                    k += 1
                for c in range(6):
                    out[k, c] += data[start + (6 * u + c) * nt + a]


@njit(cache=True, error_model="numpy", nogil=True)
def add_transposed(indptr, indices, out):
    """``A + A^T`` in place of A, ``out (nnz, 6)``; the pattern is symmetric, columns increase."""
    following = indptr[:-1].copy()  # rows in order reach the columns of each row in order
    for a in range(indptr.size - 1):
        for j in range(indptr[a], indptr[a + 1]):
            b = indices[j]
            if b >= a:
                k = following[b]
                for c in range(6):
                    out[j, c] += out[k, c]
                    out[k, c] = out[j, c]
                following[b] += 1
