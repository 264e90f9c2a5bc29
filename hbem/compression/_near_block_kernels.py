"""Compiled near blocks on density dofs: plain kernels between supports, tested on both sides.

A block ``(6, n_s, n_t)`` holds the components 00 01 02 11 12 22 of ``int int N_a G N_b`` over the
plain points; both kernels are symmetric in their indices. Each target cluster writes its own
blocks and values: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet_components, stresslet_components

TARGETS = 64  # targets of one sweep
SOURCES = 18  # sources of one sweep: their kernel values stay in the first cache


@njit(cache=True, error_model="numpy", nogil=True)
def add_lines(out, count, kernels, which, weights):
    """``out += sum_k weights[k] kernels[which[k]]``, three a sweep: supports come in threes."""
    k = 0
    while k + 3 <= count:
        a, b, c = kernels[which[k]], kernels[which[k + 1]], kernels[which[k + 2]]
        wa, wb, wc = weights[k], weights[k + 1], weights[k + 2]
        for p in range(out.size):
            out[p] += wa * a[p] + wb * b[p] + wc * c[p]
        k += 3
    while k < count:
        a, wa = kernels[which[k]], weights[k]
        for p in range(out.size):
            out[p] += wa * a[p]
        k += 1


@njit(cache=True, error_model="numpy", nogil=True)
def one_block(
    positions, normals, tiny, pt, ps, it, is_, basis_ptr, basis_rows, basis_values, local, out
):  # fmt: skip
    """Block ``out (6, n_s, n_t)`` of two clusters: points pt, ps of the supports of it, is_."""
    m, q, nt, ns = pt.size, ps.size, it.size, is_.size
    kernels = np.empty((SOURCES, 6, TARGETS))
    lines = kernels.reshape(SOURCES, 6 * TARGETS)
    potentials = np.empty((ns, 6, TARGETS))
    flat = potentials.reshape(ns, 6 * TARGETS)
    x, y, normal = np.empty((3, TARGETS)), np.empty(3), np.empty(min(3, 3 * normals.shape[1]))
    which, weights = np.empty(SOURCES, np.int64), np.empty(SOURCES)
    at_t, at_s = np.empty(nt, np.int64), np.empty(ns, np.int64)
    for a in range(nt):
        at_t[a] = basis_ptr[it[a]]
    out[:] = 0.0
    for p0 in range(0, m, TARGETS):
        p1 = min(p0 + TARGETS, m)
        for c in range(3):
            for t in range(TARGETS):
                x[c, t] = positions[c, pt[min(p0 + t, m - 1)]]
        potentials[:] = 0.0
        for b in range(ns):
            at_s[b] = basis_ptr[is_[b]]
        for j in range(q):
            local[ps[j]] = j
        for q0 in range(0, q, SOURCES):
            q1 = min(q0 + SOURCES, q)
            for j in range(q0, q1):
                for c in range(3):
                    y[c] = positions[c, ps[j]]
                for c in range(normal.size):
                    normal[c] = normals[c, ps[j]]
                if normal.size == 0:
                    stokeslet_components(OVER_8_PI, x, y, tiny, kernels[j - q0])
                else:
                    stresslet_components(OVER_8_PI, x, y, normal, tiny, kernels[j - q0])
            for b in range(ns):
                k, count = at_s[b], 0
                while k < basis_ptr[is_[b] + 1] and local[basis_rows[k]] < q1:
                    which[count] = local[basis_rows[k]] - q0
                    weights[count] = basis_values[k]
                    count += 1
                    k += 1
                at_s[b] = k
                add_lines(flat[b], count, lines, which, weights)
        for j in range(m):
            local[pt[j]] = j
        for a in range(nt):
            k = at_t[a]
            while k < basis_ptr[it[a] + 1] and local[basis_rows[k]] < p1:
                w, p = basis_values[k], local[basis_rows[k]] - p0
                for c in range(6):
                    for b in range(ns):
                        out[c, b, a] += w * potentials[b, c, p]
                k += 1
            at_t[a] = k


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
        local = np.empty(positions.shape[1], np.int32)
        block = np.empty((6, is_.size, it.size))
        one_block(
            positions, normals, tiny, pt, ps, it, is_, basis_ptr, basis_rows, basis_values, local,
            block,
        )  # fmt: skip
        out = data[data_ptr[k] : data_ptr[k + 1]].reshape(6, is_.size, it.size)
        for c in range(6):
            for b in range(is_.size):
                for a in range(it.size):
                    out[c, b, a] = block[c, b, a]
        if mirror[k] >= 0:
            other = data[data_ptr[mirror[k]] : data_ptr[mirror[k] + 1]]
            turned = other.reshape(6, it.size, is_.size)
            for c in range(6):
                for b in range(is_.size):
                    for a in range(it.size):
                        turned[c, a, b] = block[c, b, a]


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
