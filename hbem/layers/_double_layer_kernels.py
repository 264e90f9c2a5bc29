"""Compiled plain point sums of the double layer: stresslets [T 3.10b] of weighted normals.

Targets come in blocks of `BLOCK`, the last one filled up with copies of its last target: one
vector operation a source, as for the single layer.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stresslet, stresslet_components
from ._point_sum_kernels import BLOCK


@njit(cache=True, error_model="numpy", nogil=True)
def add_double(x, y, normal, strengths, tiny, r, five, out):
    """Stresslets of k strengths (k, 3) at y, at all targets of a block; r and five are scratch."""
    y0, y1, y2 = y[0], y[1], y[2]
    n0, n1, n2 = normal[0], normal[1], normal[2]
    for t in range(BLOCK):
        r0, r1, r2 = x[0, t] - y0, x[1, t] - y1, x[2, t] - y2
        five[t] = stresslet(OVER_8_PI, r0, r1, r2, n0, n1, n2, tiny)
        r[0, t], r[1, t], r[2, t] = r0, r1, r2
    for k in range(strengths.shape[0]):
        f0, f1, f2 = strengths[k, 0], strengths[k, 1], strengths[k, 2]
        u = out[k]
        for t in range(BLOCK):
            along = (r[0, t] * f0 + r[1, t] * f1 + r[2, t] * f2) * five[t]
            u[0, t] += along * r[0, t]
            u[1, t] += along * r[1, t]
            u[2, t] += along * r[2, t]


@njit(cache=True, error_model="numpy", nogil=True)
def double_sums(span, targets, sources, normals, strengths, tiny, out):
    """Sums for k strengths ``(n_sources, k, 3)``.

    Parameters
    ----------
    targets : (n_blocks, 3, BLOCK) array
    sources, normals : (n_sources, 3) array
        Normals carry the quadrature weights.
    out : (n_blocks, k, 3, BLOCK) array
        Overwritten.
    """
    for b in range(span[0], span[1]):
        r, five = np.empty((3, BLOCK)), np.empty(BLOCK)
        out[b] = 0.0
        for q in range(sources.shape[0]):
            add_double(targets[b], sources[q], normals[q], strengths[q], tiny, r, five, out[b])


@njit(cache=True, error_model="numpy", nogil=True)
def kernel_sums(span, targets, sources, normals, tiny, out):
    """Sums of the kernel itself, six components: ``out (n_blocks, 6, BLOCK)``, overwritten."""
    for b in range(span[0], span[1]):
        kernel = np.empty((6, BLOCK))
        out[b] = 0.0
        for q in range(sources.shape[0]):
            stresslet_components(OVER_8_PI, targets[b], sources[q], normals[q], tiny, kernel)
            for c in range(6):
                for t in range(BLOCK):
                    out[b, c, t] += kernel[c, t]


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def double_matrix(span, targets, sources, normals, tiny, out):
    """Components of one block of targets with every source: ``out (6, n_sources, BLOCK)``."""
    for q in range(span[0], span[1]):
        stresslet_components(OVER_8_PI, targets, sources[q], normals[q], tiny, out[:, q])
