"""Compiled products with the far field of an H-matrix: one dense panel a leaf, read twice.

The panel of a leaf holds the rows of the factors of all blocks of the leaf and its ancestors,
side by side: first ``z = L^T x`` leaf by leaf, sums of z over each cluster, exchange between the
partners of blocks, then ``y = L z``. Every leaf writes its own values: results do not depend on
threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

FOLD = 8  # panel widths are padded to multiples


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def gather(span, panel_ptr, width, leaf_ptr, panels, x, z_ptr, z):
    """``z = L^T x`` for every leaf; ``x (k, 3, n)``, ``z (k, sum of widths)``."""
    for leaf in range(span[0], span[1]):
        first, m, w = leaf_ptr[leaf], leaf_ptr[leaf + 1] - leaf_ptr[leaf], width[leaf]
        panel = panels[panel_ptr[leaf] : panel_ptr[leaf + 1]].reshape(3 * m, w)
        for v in range(x.shape[0]):
            line = z[v, z_ptr[leaf] : z_ptr[leaf] + w]
            line[:] = 0.0
            for c in range(3):
                i = 0
                while i + 4 <= m:
                    r = c * m + i
                    p0, p1, p2, p3 = panel[r], panel[r + 1], panel[r + 2], panel[r + 3]
                    x0, x1 = x[v, c, first + i], x[v, c, first + i + 1]
                    x2, x3 = x[v, c, first + i + 2], x[v, c, first + i + 3]
                    for k in range(w):
                        line[k] += x0 * p0[k] + x1 * p1[k] + (x2 * p2[k] + x3 * p3[k])
                    i += 4
                while i < m:
                    p, x0 = panel[c * m + i], x[v, c, first + i]
                    for k in range(w):
                        line[k] += x0 * p[k]
                    i += 1


@njit(cache=True, error_model="numpy", nogil=True)
def exchange(span, z, sources, source_ptr, source_length, z_in, z_ptr, slots):
    """Sum z over the leaves of each factor, hand it to the partner, spread it to its leaves.

    Factor k (one side of a block) collects ``source_length[k]`` values from the places
    ``sources[source_ptr[k]:source_ptr[k + 1]]`` and puts them to the same number of places in
    ``slots[z_ptr[k]:z_ptr[k + 1]]``, those of the other side.
    """
    for k in range(span[0], span[1]):
        n = source_length[k]
        for v in range(z.shape[0]):
            value = np.zeros(n, z.dtype)
            for p in range(source_ptr[k], source_ptr[k + 1]):
                start = sources[p]
                for r in range(n):
                    value[r] += z[v, start + r]
            for p in range(z_ptr[k], z_ptr[k + 1]):
                start = slots[p]
                for r in range(n):
                    z_in[v, start + r] = value[r]


@njit(cache=True, error_model="numpy", nogil=True)
def folded(a, b, h, sums):
    """``a . b`` of length 8 h: products folded eight to one in vector operations, then summed."""
    for k in range(h):
        sums[k] = (
            (a[k] * b[k] + a[h + k] * b[h + k])
            + (a[2 * h + k] * b[2 * h + k] + a[3 * h + k] * b[3 * h + k])
        ) + (
            (a[4 * h + k] * b[4 * h + k] + a[5 * h + k] * b[5 * h + k])
            + (a[6 * h + k] * b[6 * h + k] + a[7 * h + k] * b[7 * h + k])
        )
    q = h // 4
    for k in range(q):
        sums[k] = (sums[k] + sums[q + k]) + (sums[2 * q + k] + sums[3 * q + k])
    total = b.dtype.type(0.0)
    for k in range(q):
        total += sums[k]
    for k in range(4 * q, h):
        total += sums[k]
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def scatter(span, panel_ptr, width, leaf_ptr, panels, z_ptr, z, y):
    """``y += L z`` for every leaf."""
    for leaf in range(span[0], span[1]):
        first, m, w = leaf_ptr[leaf], leaf_ptr[leaf + 1] - leaf_ptr[leaf], width[leaf]
        if w > 0:
            panel = panels[panel_ptr[leaf] : panel_ptr[leaf + 1]].reshape(3 * m, w)
            sums = np.empty(w // FOLD, z.dtype)
            for v in range(z.shape[0]):
                line = z[v, z_ptr[leaf] : z_ptr[leaf] + w]
                for c in range(3):
                    for i in range(m):
                        y[v, c, first + i] += folded(panel[c * m + i], line, w // FOLD, sums)


@njit(cache=True, error_model="numpy", nogil=True)
def fill(
    blocks, ranks, store, left, right, left_base, right_base, first_leaf, last_leaf, leaf_ptr,
    left_width, right_width, left_ptr, right_ptr, left_panels, right_panels,
):  # fmt: skip
    """Copy the factors of some blocks into the panels.

    ``left, right (n,)`` are the columns of each block's factors within the panels of its node t
    and s, counted from ``left_base, right_base (n_nodes,)``.
    """
    used = 0
    for k in range(ranks.size):
        for side in range(2):
            rank, node = ranks[k], blocks[k, side]
            begin = leaf_ptr[first_leaf[node]]
            n = leaf_ptr[last_leaf[node] + 1] - begin
            if rank > 0:
                part = store[used : used + rank * 3 * n].reshape(rank, 3, n)
                used += rank * 3 * n
                column = left[k] + left_base[node] if side == 0 else right[k] + right_base[node]
                width = left_width if side == 0 else right_width
                ptr = left_ptr if side == 0 else right_ptr
                panels = left_panels if side == 0 else right_panels
                for leaf in range(first_leaf[node], last_leaf[node] + 1):
                    w = width[leaf]
                    m = leaf_ptr[leaf + 1] - leaf_ptr[leaf]
                    offset = leaf_ptr[leaf] - begin
                    panel = panels[ptr[leaf] : ptr[leaf + 1]].reshape(3 * m, w)
                    for c in range(3):
                        for i in range(m):
                            for r in range(rank):
                                panel[c * m + i, column + r] = part[r, c, offset + i]
