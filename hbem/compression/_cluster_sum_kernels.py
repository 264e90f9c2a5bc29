"""Compiled sums of plain kernels between clusters of points, nothing stored.

Targets of a cluster side by side, sources outermost: every inner loop is a vector operation.
Single precision takes positions relative to the target cluster before it rounds them; double
precision takes differences of the positions themselves. Every target cluster writes its own
values: results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet, stresslet
from .cluster_tree import LANES

SINGLE_TINY = 1e-24  # squared distance below which powers leave the range of single precision


@njit(cache=True, error_model="numpy", nogil=True)
def add_single(x, y, f, tiny, count, out):
    """Velocities ``out (3, n)`` at targets ``x (3, n)`` of ``count`` point forces f at y."""
    one = f.dtype.type(1.0)
    x0, x1, x2 = x[0], x[1], x[2]
    u0, u1, u2 = out[0], out[1], out[2]
    for j in range(count):
        y0, y1, y2 = y[0, j], y[1, j], y[2, j]
        f0, f1, f2 = f[0, j], f[1, j], f[2, j]
        for t in range(x0.size):
            r0, r1, r2 = x0[t] - y0, x1[t] - y1, x2[t] - y2
            a, b = stokeslet(one, r0, r1, r2, tiny)
            along = (r0 * f0 + r1 * f1 + r2 * f2) * b
            u0[t] += a * f0 + along * r0
            u1[t] += a * f1 + along * r1
            u2[t] += a * f2 + along * r2


@njit(cache=True, error_model="numpy", nogil=True)
def add_double(x, y, f, normals, tiny, count, out):
    """The same for stresslets ``6 r (r . f) (r . n) / r^5``."""
    one = f.dtype.type(1.0)
    x0, x1, x2 = x[0], x[1], x[2]
    u0, u1, u2 = out[0], out[1], out[2]
    for j in range(count):
        y0, y1, y2 = y[0, j], y[1, j], y[2, j]
        f0, f1, f2 = f[0, j], f[1, j], f[2, j]
        n0, n1, n2 = normals[0, j], normals[1, j], normals[2, j]
        for t in range(x0.size):
            r0, r1, r2 = x0[t] - y0, x1[t] - y1, x2[t] - y2
            c = stresslet(one, r0, r1, r2, n0, n1, n2, tiny)
            along = (r0 * f0 + r1 * f1 + r2 * f2) * c
            u0[t] += along * r0
            u1[t] += along * r1
            u2[t] += along * r2


@njit(cache=True, error_model="numpy", nogil=True)
def cluster_sums(
    span, targets, target_ptr, sources, source_ptr, normals, partner_ptr, partners, charges, tiny,
    out,
):  # fmt: skip
    """Add sums over the partner clusters of every target cluster to ``out (k, 3, n_targets)``.

    Parameters
    ----------
    targets, sources : (3, n) array
        Cluster c holds the points ``ptr[c] : ptr[c + 1]``.
    normals : (3, n_sources) array
        ``(3, 0)`` for the single layer.
    partner_ptr, partners :
        Source clusters of each target cluster.
    charges : (k, 3, n_sources) array
        Its precision is the precision of the sums.
    """
    kind = charges.dtype.type
    single = charges.itemsize == 4
    small = kind(max(tiny, SINGLE_TINY) if single else tiny)
    scale = kind(OVER_8_PI)
    for c in range(span[0], span[1]):
        first, m = target_ptr[c], target_ptr[c + 1] - target_ptr[c]
        if m > 0 and partner_ptr[c + 1] > partner_ptr[c]:
            padded = (m + LANES - 1) // LANES * LANES
            x = np.empty((3, padded), charges.dtype)
            total = np.zeros((charges.shape[0], 3, padded), charges.dtype)
            centre = np.zeros(3)
            for i in range(3):
                if single:
                    for t in range(m):
                        centre[i] += targets[i, first + t] / m
                for t in range(padded):
                    x[i, t] = targets[i, first + min(t, m - 1)] - centre[i]
            size = 0
            for k in range(partner_ptr[c], partner_ptr[c + 1]):
                s = partners[k]
                size = max(size, source_ptr[s + 1] - source_ptr[s])
            y = np.empty((3, size), charges.dtype)
            ny = np.empty((3, size if normals.shape[1] > 0 else 0), charges.dtype)
            for k in range(partner_ptr[c], partner_ptr[c + 1]):
                s = partners[k]
                begin, n = source_ptr[s], source_ptr[s + 1] - source_ptr[s]
                for i in range(3):
                    for j in range(n):
                        y[i, j] = sources[i, begin + j] - centre[i]
                    if normals.shape[1] > 0:
                        for j in range(n):
                            ny[i, j] = normals[i, begin + j]
                for v in range(charges.shape[0]):
                    f = charges[v, :, begin : begin + n]
                    if normals.shape[1] > 0:
                        add_double(x, y, f, ny, small, n, total[v])
                    else:
                        add_single(x, y, f, small, n, total[v])
            for v in range(charges.shape[0]):
                for i in range(3):
                    for t in range(m):
                        out[v, i, first + t] += scale * total[v, i, t]
