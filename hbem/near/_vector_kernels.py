"""Compiled kernel values and moment sums of `LANES` near pairs side by side.

Flat arrays with the lane innermost and loops of constant length, as in `_patch_lane_kernels`.
The single layer keeps a form of its own, with the surface element ``|a x b|`` under the root: one
root instead of two. Written with `hbem._stokes_kernels.stokeslet` it took 1.5 to 4 times as long.
Two nodes at a time are added to the sums: these are loaded and stored half as often.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._patch_lane_kernels import LANES, lane, line_values


@njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
def components(layer, r0, r1, r2, a0, a1, a2, b0, b1, b2, tiny):
    """Components 00 01 02 11 12 22 of 8 pi times a kernel and ``|a x b|``; ``r = y - x``.

    The unit normal of the double layer times ``|a x b|`` is ``a x b``.
    """
    n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    square = r0 * r0 + r1 * r1 + r2 * r2
    inverse = 1.0 / square if square > tiny else 0.0
    if len(layer) == 0:
        one = np.sqrt((n0 * n0 + n1 * n1 + n2 * n2) * inverse)
        three = one * inverse
    else:
        one = 0.0
        three = (r0 * n0 + r1 * n1 + r2 * n2) * -6.0 * inverse * inverse * np.sqrt(inverse)
    t0, t1 = three * r0, three * r1
    return one + t0 * r0, t0 * r1, t0 * r2, one + t1 * r1, t1 * r2, one + three * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
def row_values(form, row, u, x, tiny):
    """`components` of one lane at one node of a row: u is ``2 s - 1``."""
    n = len(form[0])
    r0, a0 = line_values(form[0], row, x, LANES, u)
    r1, a1 = line_values(form[0], row, n * LANES + x, LANES, u)
    r2, a2 = line_values(form[0], row, 2 * n * LANES + x, LANES, u)
    b0, _ = line_values(form[0], row, 3 * n * LANES + x, LANES, u)
    b1, _ = line_values(form[0], row, 4 * n * LANES + x, LANES, u)
    b2, _ = line_values(form[0], row, 5 * n * LANES + x, LANES, u)
    return components(form[2], r0, r1, r2, a0, a1, a2, b0, b1, b2, tiny)


@njit(cache=True, error_model="numpy", nogil=True)
def add_nodes(form, row, nodes, tiny, sums):
    """Add two nodes of a row: ``nodes (2, m + 1, LANES)`` to ``sums (m, 6, LANES)``."""
    m, n = len(form[1]), LANES
    for x in range(LANES):
        p0, p1, p2, p3, p4, p5 = row_values(form, row, nodes[x], x, tiny)
        q0, q1, q2, q3, q4, q5 = row_values(form, row, nodes[(m + 1) * n + x], x, tiny)
        for i in range(m):
            o, v, w = 6 * i * n + x, nodes[(1 + i) * n + x], nodes[(m + 2 + i) * n + x]
            sums[o] += v * p0 + w * q0
            sums[n + o] += v * p1 + w * q1
            sums[2 * n + o] += v * p2 + w * q2
            sums[3 * n + o] += v * p3 + w * q3
            sums[4 * n + o] += v * p4 + w * q4
            sums[5 * n + o] += v * p5 + w * q5


@njit(cache=True, error_model="numpy", nogil=True)
def add_row(form, values, sums, moments):
    """Add a row: ``moments (m, m, 6, LANES)`` by ``sums (m, 6, LANES)``, ``values (m, LANES)``."""
    m, n = len(form[1]), LANES
    for i in range(m):
        part, out = sums[6 * i * n : 6 * (i + 1) * n], moments[6 * m * i * n : 6 * m * (i + 1) * n]
        for x in range(LANES):
            k0, k1, k2 = part[x], part[n + x], part[2 * n + x]
            k3, k4, k5 = part[3 * n + x], part[4 * n + x], part[5 * n + x]
            for j in range(m):
                o, v = 6 * j * n + x, values[j * n + x]
                out[o] += v * k0
                out[n + o] += v * k1
                out[2 * n + o] += v * k2
                out[3 * n + o] += v * k3
                out[4 * n + o] += v * k4
                out[5 * n + o] += v * k5


@njit(cache=True, error_model="numpy", nogil=True)
def point_values(form, row, node, tiny, values):
    """Six `components` at one node of every lane: ``values (6, LANES)``."""
    n = LANES
    for x in range(LANES):
        k0, k1, k2, k3, k4, k5 = row_values(form, row, node[x], x, tiny)
        values[x], values[n + x], values[2 * n + x] = k0, k1, k2
        values[3 * n + x], values[4 * n + x], values[5 * n + x] = k3, k4, k5


@njit(cache=True, error_model="numpy", nogil=True)
def add_points(form, values, s, t, moments):
    """Add two points anywhere: ``values (2, 6, LANES)``, node tables ``s, t (2, m + 1, LANES)``."""
    m, n = len(form[1]), LANES
    for i in range(m):
        out = moments[6 * m * i * n : 6 * m * (i + 1) * n]
        first, second = lane(s, 1 + i), lane(s, m + 2 + i)
        for x in range(LANES):
            for j in range(m):
                o = 6 * j * n + x
                v, w = first[x] * t[(1 + j) * n + x], second[x] * t[(m + 2 + j) * n + x]
                out[o] += v * values[x] + w * values[6 * n + x]
                out[n + o] += v * values[n + x] + w * values[7 * n + x]
                out[2 * n + o] += v * values[2 * n + x] + w * values[8 * n + x]
                out[3 * n + o] += v * values[3 * n + x] + w * values[9 * n + x]
                out[4 * n + o] += v * values[4 * n + x] + w * values[10 * n + x]
                out[5 * n + o] += v * values[5 * n + x] + w * values[11 * n + x]
