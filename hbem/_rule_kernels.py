"""Compiled closest point of a patch: Bernstein tables, derivatives, projected Newton.

Patches stay in Bernstein form: safe at degree 8.
"""

from __future__ import annotations

import numpy as np
from numba import njit

MAX_STEPS = 20  # of the closest-point iteration
SMALLEST = 1e-6  # relative distance below which the sinh rule is not graded further


@njit(cache=True, error_model="numpy", nogil=True)
def bernstein(degree, x, values, slopes):
    """Bernstein polynomials and their derivatives at one point."""
    y = 1.0 - x
    values[0] = 1.0
    slopes[0] = 0.0
    for k in range(1, degree + 1):
        if k == degree:
            below = 0.0
            for i in range(degree):
                slopes[i] = degree * (below - values[i])
                below = values[i]
            slopes[degree] = degree * below
        carry = 0.0
        for i in range(k):
            v = values[i]
            values[i] = carry + y * v
            carry = x * v
        values[k] = carry


@njit(cache=True, error_model="numpy", nogil=True)
def curvature_row(degree, x, values, bends):
    """Second derivatives of the Bernstein polynomials; ``values`` is scratch."""
    for i in range(degree + 1):
        bends[i] = 0.0
    if degree < 2:
        return
    bernstein(degree - 2, x, values, bends)
    factor = degree * (degree - 1)
    for i in range(degree + 1):
        bends[i] = 0.0
    for i in range(degree - 1):
        v = factor * values[i]
        bends[i] += v
        bends[i + 1] -= 2.0 * v
        bends[i + 2] += v


@njit(cache=True, error_model="numpy", nogil=True)
def jet(control, s, t, scratch, out):
    """Position and derivatives s, t, ss, st, tt at one point: ``out (6, 3)``."""
    n = control.shape[0]
    curvature_row(n - 1, s, scratch[0], scratch[2])
    bernstein(n - 1, s, scratch[0], scratch[1])
    curvature_row(n - 1, t, scratch[3], scratch[5])
    bernstein(n - 1, t, scratch[3], scratch[4])
    for c in range(3):
        x, xs, xt, xss, xst, xtt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            v, vt, vtt = 0.0, 0.0, 0.0
            for j in range(n):
                p = control[i, j, c]
                v += p * scratch[3, j]
                vt += p * scratch[4, j]
                vtt += p * scratch[5, j]
            x += v * scratch[0, i]
            xs += v * scratch[1, i]
            xss += v * scratch[2, i]
            xt += vt * scratch[0, i]
            xst += vt * scratch[1, i]
            xtt += vtt * scratch[0, i]
        out[0, c], out[1, c], out[2, c] = x, xs, xt
        out[3, c], out[4, c], out[5, c] = xss, xst, xtt


@njit(cache=True, error_model="numpy", nogil=True)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy", nogil=True)
def descent(s, t, box, r, out):
    """Newton step towards the closest point; Gauss-Newton where the Hessian is not positive."""
    a11, a12, a22 = dot(out[1], out[1]), dot(out[1], out[2]), dot(out[2], out[2])
    g1, g2 = dot(r, out[1]), dot(r, out[2])
    free1 = not ((s <= box[0] and g1 > 0.0) or (s >= box[1] and g1 < 0.0))
    free2 = not ((t <= box[2] and g2 > 0.0) or (t >= box[3] and g2 < 0.0))
    floor = 1e-12 * (a11 + a22) + 1e-300
    h11, h22 = a11 + dot(r, out[3]), a22 + dot(r, out[5])
    h12 = a12 + dot(r, out[4])
    if free1 and free2:
        det = h11 * h22 - h12 * h12
        if h11 <= 0.0 or det <= 1e-6 * a11 * a22 + floor * floor:
            h11, h22, h12 = a11 + floor, a22 + floor, a12
            det = h11 * h22 - h12 * h12
        return -(h22 * g1 - h12 * g2) / det, -(h11 * g2 - h12 * g1) / det
    if free1:
        return -g1 / (h11 if h11 > 0.1 * a11 + floor else a11 + floor), 0.0
    if free2:
        return 0.0, -g2 / (h22 if h22 > 0.1 * a22 + floor else a22 + floor)
    return 0.0, 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def closest(control, x, box, s, t, scratch, out, r):
    """Closest point of a box of a patch to ``x`` by projected Newton from ``(s, t)``.

    Returns ``s, t`` and the distance; ``out`` holds the jet there. Ends when a step is below a
    twentieth of the distance: the near rule does not see more.
    """
    jet(control, s, t, scratch, out)
    for c in range(3):
        r[c] = out[0, c] - x[c]
    square = dot(r, r)
    for _ in range(MAX_STEPS):
        ds, dt = descent(s, t, box, r, out)
        moved = False
        for _ in range(6):
            s1 = min(box[1], max(box[0], s + ds))
            t1 = min(box[3], max(box[2], t + dt))
            size = 0.0
            for c in range(3):
                size += (out[1, c] * (s1 - s) + out[2, c] * (t1 - t)) ** 2
            if size <= 1e-4 * square:
                return s1, t1, np.sqrt(square)
            jet(control, s1, t1, scratch, out)
            for c in range(3):
                r[c] = out[0, c] - x[c]
            new = dot(r, r)
            if new < square:
                small = size <= 2.5e-3 * new
                s, t, square, moved = s1, t1, new, True
                break
            ds, dt = 0.5 * ds, 0.5 * dt
            jet(control, s, t, scratch, out)
        if not moved:
            for c in range(3):
                r[c] = out[0, c] - x[c]
            break
        if small:
            break
    return s, t, np.sqrt(square)
