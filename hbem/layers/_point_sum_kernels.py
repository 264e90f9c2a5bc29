"""Compiled plain point sums: every target with every source, kernel values never stored.

Targets come in blocks of `BLOCK`, the last one filled up with copies of its last target: one
vector operation a source; sources outermost. The sum over sources runs in order for every target:
results do not depend on threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet

BLOCK = 64  # targets that share a sweep over the sources
SOURCES = 20  # sources whose kernel values are held at a time for many strengths


@njit(cache=True, error_model="numpy", nogil=True)
def add_single(x, y, f, tiny, out):
    """Stokeslet of strength f (3,) at y, at all targets of a block: ``x (3, BLOCK)``."""
    y0, y1, y2 = y[0], y[1], y[2]
    f0, f1, f2 = OVER_8_PI * f[0], OVER_8_PI * f[1], OVER_8_PI * f[2]
    for t in range(BLOCK):
        r0, r1, r2 = x[0, t] - y0, x[1, t] - y1, x[2, t] - y2
        a, b = stokeslet(1.0, r0, r1, r2, tiny)
        along = (r0 * f0 + r1 * f1 + r2 * f2) * b
        out[0, t] += a * f0 + along * r0
        out[1, t] += a * f1 + along * r1
        out[2, t] += a * f2 + along * r2


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def single_layer_sums(span, targets, sources, strengths, tiny, out):
    """Single-layer velocities: strengths ``(n_sources, 3)``; see `add_single`.

    Parameters
    ----------
    targets, out : (n_blocks, 3, BLOCK) array
        Targets; the result, overwritten.
    sources : (n_sources, 3) array
    """
    for b in range(span[0], span[1]):
        out[b] = 0.0
        for q in range(sources.shape[0]):
            add_single(targets[b], sources[q], strengths[q], tiny, out[b])


@njit(cache=True, error_model="numpy", nogil=True)
def kernel_rows(x, y, strength, tiny, rows):
    """Kernel between `SOURCES` sources and a block of targets: ``rows (SOURCES, 3, 3, BLOCK)``."""
    for q in range(y.shape[0]):
        y0, y1, y2 = y[q, 0], y[q, 1], y[q, 2]
        g = rows[q]
        for t in range(BLOCK):
            r0, r1, r2 = x[0, t] - y0, x[1, t] - y1, x[2, t] - y2
            one, three = stokeslet(strength, r0, r1, r2, tiny)
            g[0, 0, t] = one + three * r0 * r0
            g[1, 1, t] = one + three * r1 * r1
            g[2, 2, t] = one + three * r2 * r2
            g[0, 1, t] = g[1, 0, t] = three * r0 * r1
            g[0, 2, t] = g[2, 0, t] = three * r0 * r2
            g[1, 2, t] = g[2, 1, t] = three * r1 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def single_layer_block_sums(span, targets, sources, strengths, strength, tiny, out):
    """The same for k strengths at once, as small matrix products; all in one precision.

    Parameters
    ----------
    targets : (n_blocks, 3, BLOCK) array
    sources : (n_groups, SOURCES, 3) array
    strengths : (n_groups, k, 3 * SOURCES) array
        Zero for sources that only fill the last group.
    strength, tiny : float
        ``1 / (8 pi)``, and the squared distance of coincident points.
    out : (n_blocks, k, 3 * BLOCK) array
        Overwritten.
    """
    for b in range(span[0], span[1]):
        rows = np.empty((SOURCES, 3, 3, BLOCK), out.dtype)
        flat = rows.reshape(3 * SOURCES, 3 * BLOCK)
        part, total = np.empty_like(out[b]), out[b]
        total[:] = 0.0
        for q in range(sources.shape[0]):
            kernel_rows(targets[b], sources[q], strength, tiny, rows)
            np.dot(strengths[q], flat, part)
            total += part
