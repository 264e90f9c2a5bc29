"""Compiled kernel values and moment sums of `LANES` near pairs side by side.

Flat arrays with the lane innermost and loops of constant length, as in `_patch_lane_kernels`.
The single layer keeps a form of its own, with the surface element ``|a x b|`` under the root: one
root instead of two. Written with `hbem._stokes_kernels.stokeslet` it took 1.5 to 4 times as long.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stresslet
from ._patch_lane_kernels import LANES, cubic, general, quadratic


@njit(cache=True, error_model="numpy", nogil=True)
def single(r0, r1, r2, a0, a1, a2, b0, b1, b2, w, tiny):
    """Components of the single layer times ``w |a x b|``."""
    n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    square = r0 * r0 + r1 * r1 + r2 * r2
    inverse = 1.0 / (square if square > tiny else tiny)
    one = w * OVER_8_PI * np.sqrt((n0 * n0 + n1 * n1 + n2 * n2) * inverse)
    one = one if square > tiny else 0.0
    three = one * inverse
    t0, t1 = three * r0, three * r1
    return one + t0 * r0, t0 * r1, t0 * r2, one + t1 * r1, t1 * r2, one + three * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def double(r0, r1, r2, a0, a1, a2, b0, b1, b2, w, tiny):
    """Components of the double layer, the unit normal times ``|a x b|`` being ``a x b``."""
    n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    five = stresslet(w * OVER_8_PI, r0, r1, r2, n0, n1, n2, tiny)
    t0, t1 = five * r0, five * r1
    return t0 * r0, t0 * r1, t0 * r2, t1 * r1, t1 * r2, five * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def components(layer, r0, r1, r2, a0, a1, a2, b0, b1, b2, w, tiny):
    """`single` or `double`; the compiler takes the choice out of a loop over lanes."""
    if layer == 0:
        return single(r0, r1, r2, a0, a1, a2, b0, b1, b2, w, tiny)
    return double(r0, r1, r2, a0, a1, a2, b0, b1, b2, w, tiny)


@njit(cache=True, error_model="numpy", nogil=True)
def quadratic_values(layer, target, row, sigma, ws, wt, tiny, out):
    """`kernel_values` of biquadratic patches."""
    n = LANES
    for x in range(LANES):
        out[x], out[n + x], out[2 * n + x], out[3 * n + x], out[4 * n + x], out[5 * n + x] = (
            components(layer, *quadratic(target, row, sigma[x], x), ws[x] * wt[x], tiny)
        )


@njit(cache=True, error_model="numpy", nogil=True)
def cubic_values(layer, target, row, sigma, ws, wt, tiny, out):
    """`kernel_values` of bicubic patches."""
    n = LANES
    for x in range(LANES):
        out[x], out[n + x], out[2 * n + x], out[3 * n + x], out[4 * n + x], out[5 * n + x] = (
            components(layer, *cubic(target, row, sigma[x], x), ws[x] * wt[x], tiny)
        )


@njit(cache=True, error_model="numpy", nogil=True)
def general_values(layer, place, ws, wt, tiny, out):
    """`kernel_values` from `general` points."""
    n = LANES
    for x in range(LANES):
        out[x], out[n + x], out[2 * n + x], out[3 * n + x], out[4 * n + x], out[5 * n + x] = (
            components(
                layer, place[x], place[n + x], place[2 * n + x],
                place[3 * n + x], place[4 * n + x], place[5 * n + x],
                place[6 * n + x], place[7 * n + x], place[8 * n + x],
                ws[x] * wt[x], tiny,
            )
        )  # fmt: skip


@njit(cache=True, error_model="numpy", nogil=True)
def kernel_values(g, layer, target, row, sigma, ws, wt, tiny, place, out):
    """Six kernel components at one node of every lane: ``out (6, LANES)``.

    ``layer`` 0 is the single layer, 1 the double; g the degree of the patch.
    """
    if g == 2:
        quadratic_values(layer, target, row, sigma, ws, wt, tiny, out)
    elif g == 3:
        cubic_values(layer, target, row, sigma, ws, wt, tiny, out)
    else:
        general(g, target, row, sigma, place)
        general_values(layer, place, ws, wt, tiny, out)


@njit(cache=True, error_model="numpy", nogil=True)
def add_nodes(m, values, kernel, sums):
    """Add four nodes of a row: ``sums (m, 6, ...) += values (4, m, ...) kernel (4, 6, ...)``."""
    n, o = LANES, m * LANES
    for i in range(m):
        b, a = i * n, 6 * i * n
        for x in range(LANES):
            v0, v1 = values[b + x], values[b + o + x]
            v2, v3 = values[b + 2 * o + x], values[b + 3 * o + x]
            sums[a + x] += (v0 * kernel[x] + v1 * kernel[6 * n + x]) + (
                v2 * kernel[12 * n + x] + v3 * kernel[18 * n + x]
            )
            sums[a + n + x] += (v0 * kernel[n + x] + v1 * kernel[7 * n + x]) + (
                v2 * kernel[13 * n + x] + v3 * kernel[19 * n + x]
            )
            sums[a + 2 * n + x] += (v0 * kernel[2 * n + x] + v1 * kernel[8 * n + x]) + (
                v2 * kernel[14 * n + x] + v3 * kernel[20 * n + x]
            )
            sums[a + 3 * n + x] += (v0 * kernel[3 * n + x] + v1 * kernel[9 * n + x]) + (
                v2 * kernel[15 * n + x] + v3 * kernel[21 * n + x]
            )
            sums[a + 4 * n + x] += (v0 * kernel[4 * n + x] + v1 * kernel[10 * n + x]) + (
                v2 * kernel[16 * n + x] + v3 * kernel[22 * n + x]
            )
            sums[a + 5 * n + x] += (v0 * kernel[5 * n + x] + v1 * kernel[11 * n + x]) + (
                v2 * kernel[17 * n + x] + v3 * kernel[23 * n + x]
            )


@njit(cache=True, error_model="numpy", nogil=True)
def add_node(m, values, kernel, sums):
    """Add one node; also a row: ``sums (m, 6, LANES) += values (m, LANES) kernel (6, LANES)``."""
    n = LANES
    for i in range(m):
        b, a = i * n, 6 * i * n
        for x in range(LANES):
            v = values[b + x]
            sums[a + x] += v * kernel[x]
            sums[a + n + x] += v * kernel[n + x]
            sums[a + 2 * n + x] += v * kernel[2 * n + x]
            sums[a + 3 * n + x] += v * kernel[3 * n + x]
            sums[a + 4 * n + x] += v * kernel[4 * n + x]
            sums[a + 5 * n + x] += v * kernel[5 * n + x]


@njit(cache=True, error_model="numpy", nogil=True)
def clear(sums):
    for x in range(sums.size):
        sums[x] = 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def products(m, bs, bt, values):
    """Tensor functions at one node of every lane: ``values (m, m, LANES)``."""
    for i in range(m):
        for j in range(m):
            o, p, q = (i * m + j) * LANES, i * LANES, j * LANES
            for x in range(LANES):
                values[o + x] = bs[p + x] * bt[q + x]
