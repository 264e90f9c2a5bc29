"""Compiled near blocks on density dofs: plain kernels between supports, tested on both sides.

A block ``(6, n_s, n_t)`` holds the components 00 01 02 11 12 22 of ``int int N_a G N_b`` over the
plain points; both kernels are symmetric in their indices. Each target cluster writes its own
blocks and values: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet_components, stresslet_components

# Targets and sources of one sweep: kernel values below 128 kB, beyond which memory is not reused.
TARGETS, SOURCES = 32, 64
LANES = 8  # target counts are padded to multiples: no scalar tails


@njit(cache=True, error_model="numpy", nogil=True)
def dense_basis(points, items, basis_ptr, basis_rows, basis_values, out):
    """Functions at points as ``out (n_points, n_items)``; both sides increase."""
    out[:] = 0.0
    for a in range(items.size):
        j = 0
        for k in range(basis_ptr[items[a]], basis_ptr[items[a] + 1]):
            while points[j] != basis_rows[k]:
                j += 1
            out[j, a] = basis_values[k]


@njit(cache=True, error_model="numpy", nogil=True)
def one_block(positions, normals, tiny, pt, ps, test, basis, out):
    """Block ``out (n_s, 6, n_t)`` of two clusters, as matrix products.

    ``test (n_points, n_t)``, ``basis (n_points, n_s)`` are the functions at the points pt, ps.
    """
    nt, ns = test.shape[1], basis.shape[1]
    y, normal = np.empty(3), np.empty(min(3, 3 * normals.shape[1]))
    flat = out.reshape(6 * ns, nt)
    flat[:] = 0.0
    for first in range(0, pt.size, TARGETS):
        m = min(TARGETS, pt.size - first)
        padded = (m + LANES - 1) // LANES * LANES
        x = np.empty((3, padded))
        tests = np.zeros((padded, nt), out.dtype)
        tests[:m] = test[first : first + m]
        for t in range(padded):
            for c in range(3):
                x[c, t] = positions[c, pt[first + min(t, m - 1)]]
        potentials = np.zeros((ns, 6 * padded), out.dtype)
        for begin in range(0, ps.size, SOURCES):
            q = min(SOURCES, ps.size - begin)
            kernel = np.empty((q, 6, padded), out.dtype)
            for j in range(q):
                for c in range(3):
                    y[c] = positions[c, ps[begin + j]]
                for c in range(normal.size):
                    normal[c] = normals[c, ps[begin + j]]
                if normal.size == 0:
                    stokeslet_components(OVER_8_PI, x, y, tiny, kernel[j])
                else:
                    stresslet_components(OVER_8_PI, x, y, normal, tiny, kernel[j])
            potentials += np.dot(basis[begin : begin + q].T, kernel.reshape(q, 6 * padded))
        flat += np.dot(potentials.reshape(6 * ns, padded), tests)


@njit(cache=True, error_model="numpy", nogil=True)
def near_blocks(
    span, order, clusters_t, clusters_s, mirror, item_ptr, items, point_ptr, points, positions,
    normals, tiny, basis_ptr, basis_rows, basis_values, data_ptr, data,
):  # fmt: skip
    """All near blocks of a list, the mirrored ones (number ``mirror[k] >= 0``) included.

    Points of a cluster and rows of a basis column increase. ``data_ptr (n + 1,)`` points to the
    blocks within ``data``.
    """
    for o in range(span[0], span[1]):
        k = order[o]
        t, s = clusters_t[k], clusters_s[k]
        pt, ps = points[point_ptr[t] : point_ptr[t + 1]], points[point_ptr[s] : point_ptr[s + 1]]
        it, is_ = items[item_ptr[t] : item_ptr[t + 1]], items[item_ptr[s] : item_ptr[s + 1]]
        test = np.empty((pt.size, it.size), data.dtype)
        basis = np.empty((ps.size, is_.size), data.dtype)
        dense_basis(pt, it, basis_ptr, basis_rows, basis_values, test)
        dense_basis(ps, is_, basis_ptr, basis_rows, basis_values, basis)
        block = np.empty((is_.size, 6, it.size), data.dtype)
        one_block(positions, normals, tiny, pt, ps, test, basis, block)
        out = data[data_ptr[k] : data_ptr[k + 1]].reshape(6, is_.size, it.size)
        for c in range(6):
            for b in range(is_.size):
                for a in range(it.size):
                    out[c, b, a] = block[b, c, a]
        if mirror[k] >= 0:
            other = data[data_ptr[mirror[k]] : data_ptr[mirror[k] + 1]]
            turned = other.reshape(6, it.size, is_.size)
            for c in range(6):
                for b in range(is_.size):
                    for a in range(it.size):
                        turned[c, a, b] = block[b, c, a]


@njit(cache=True, error_model="numpy", nogil=True)
def add_to_rows(
    row_leaf, row_ptr, row_functions, column_leaf, column_ptr, column_functions, order, data_ptr,
    data, turned, indptr, indices, out,
):  # fmt: skip
    """Add blocks of pairs of leaves to a sparse matrix of functions, ``out (nnz, 6)``.

    ``order`` are the blocks, sorted by the leaf of the rows; ``turned`` where the blocks have rows
    first instead of columns. The functions of a leaf are ``functions[ptr[leaf] : ptr[leaf + 1]]``.
    """
    widest = np.diff(row_ptr).max()
    place = np.empty((widest, indptr.size), np.int32)
    held = -1
    for o in range(order.size):
        k = order[o]
        t, s = row_leaf[k], column_leaf[k]
        rows = row_functions[row_ptr[t] : row_ptr[t + 1]]
        columns = column_functions[column_ptr[s] : column_ptr[s + 1]]
        if t != held:
            held = t
            for a in range(rows.size):
                start = indptr[rows[a]]
                for j in range(start, indptr[rows[a] + 1]):
                    place[a, indices[j]] = j - start
        n, m = rows.size, columns.size
        block = data[data_ptr[k] : data_ptr[k + 1]]
        step_a, step_b = (m, 1) if turned else (1, n)
        for a in range(n):
            start = indptr[rows[a]]
            for b in range(m):
                line = out[start + place[a, columns[b]]]
                for c in range(6):
                    line[c] += block[c * n * m + a * step_a + b * step_b]


@njit(cache=True, error_model="numpy", nogil=True)
def apply_blocks(span, leaf_ptr, partner_ptr, partners, data_ptr, data, x, y):
    """Add near blocks times ``x (k, 3, n)`` to ``y (k, 3, n)``, both in tree order."""
    for leaf in range(span[0], span[1]):
        first, m = leaf_ptr[leaf], leaf_ptr[leaf + 1] - leaf_ptr[leaf]
        total = np.zeros((x.shape[0], 3, m))
        for k in range(partner_ptr[leaf], partner_ptr[leaf + 1]):
            s = partners[k]
            begin, n = leaf_ptr[s], leaf_ptr[s + 1] - leaf_ptr[s]
            start = data_ptr[k]
            block = data[start : start + 6 * n * m].reshape(6, n, m)
            for v in range(x.shape[0]):
                u0, u1, u2 = total[v, 0], total[v, 1], total[v, 2]
                for b in range(n):
                    f0, f1, f2 = x[v, 0, begin + b], x[v, 1, begin + b], x[v, 2, begin + b]
                    k0, k1, k2 = block[0, b], block[1, b], block[2, b]
                    k3, k4, k5 = block[3, b], block[4, b], block[5, b]
                    for a in range(m):
                        u0[a] += k0[a] * f0 + k1[a] * f1 + k2[a] * f2
                        u1[a] += k1[a] * f0 + k3[a] * f1 + k4[a] * f2
                        u2[a] += k2[a] * f0 + k4[a] * f1 + k5[a] * f2
        for v in range(x.shape[0]):
            for c in range(3):
                for a in range(m):
                    y[v, c, first + a] += total[v, c, a]
