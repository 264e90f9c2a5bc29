"""Compiled work on the flat points of one rule: geometry, kernel values, moments.

Plain loops over contiguous points without branches or calls, so that the compiler turns them into
vector instructions; sums are factorised where the points form a tensor grid. The kernel is
``G_ik = (delta_ik / r + r_i r_k / r^3) / 8 pi`` [T 3.10a], components 00 01 02 11 12 22.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._rule_kernels import bernstein

EIGHT_PI = 8.0 * np.pi


@njit(cache=True, error_model="numpy", nogil=True)
def tables(degree, n, x, values, slopes):
    """Bernstein polynomials and derivatives at n nodes, ``(>= n, >= degree + 1)``."""
    for k in range(n):
        bernstein(degree, x[k], values[k], slopes[k])


@njit(cache=True, error_model="numpy", nogil=True)
def cubic_component(a, n, s, t, y, ys, yt):
    """One component of a bicubic patch in powers, ``a (4, 4)``, and its slopes at n points.

    Coefficients are copied to scalars: the compiler then knows that no store changes them and
    turns the loop into vector instructions.
    """
    a00, a01, a02, a03 = a[0, 0], a[0, 1], a[0, 2], a[0, 3]
    a10, a11, a12, a13 = a[1, 0], a[1, 1], a[1, 2], a[1, 3]
    a20, a21, a22, a23 = a[2, 0], a[2, 1], a[2, 2], a[2, 3]
    a30, a31, a32, a33 = a[3, 0], a[3, 1], a[3, 2], a[3, 3]
    for p in range(n):
        u, v = s[p], t[p]
        b0 = ((a03 * v + a02) * v + a01) * v + a00
        b1 = ((a13 * v + a12) * v + a11) * v + a10
        b2 = ((a23 * v + a22) * v + a21) * v + a20
        b3 = ((a33 * v + a32) * v + a31) * v + a30
        d0 = (3.0 * a03 * v + 2.0 * a02) * v + a01
        d1 = (3.0 * a13 * v + 2.0 * a12) * v + a11
        d2 = (3.0 * a23 * v + 2.0 * a22) * v + a21
        d3 = (3.0 * a33 * v + 2.0 * a32) * v + a31
        y[p] = ((b3 * u + b2) * u + b1) * u + b0
        ys[p] = (3.0 * b3 * u + 2.0 * b2) * u + b1
        yt[p] = ((d3 * u + d2) * u + d1) * u + d0


@njit(cache=True, error_model="numpy", nogil=True)
def general_geometry(control, n, bs, ds, bt, dt, position):
    """Positions and tangents at n nodes of a patch of any degree, from Bernstein tables."""
    m = control.shape[0]
    for p in range(n):
        for c in range(3):
            y, ys, yt = 0.0, 0.0, 0.0
            for i in range(m):
                v, vt = 0.0, 0.0
                for k in range(m):
                    v += control[i, k, c] * bt[p, k]
                    vt += control[i, k, c] * dt[p, k]
                y += v * bs[p, i]
                ys += v * ds[p, i]
                yt += vt * bs[p, i]
            position[3 * c, p] = y
            position[3 * c + 1, p] = ys
            position[3 * c + 2, p] = yt


@njit(cache=True, error_model="numpy", nogil=True)
def kernel_points(x, tiny, n, position, weights, kernel):
    """Six kernel components times weight and surface element at n flat points.

    ``position (9, >= n)`` holds y, y_s, y_t by component; points closer than ``sqrt(tiny)``
    give zero.
    """
    x0, x1, x2 = x[0], x[1], x[2]
    y0, ys0, yt0 = position[0], position[1], position[2]
    y1, ys1, yt1 = position[3], position[4], position[5]
    y2, ys2, yt2 = position[6], position[7], position[8]
    k0, k1, k2, k3, k4, k5 = kernel[0], kernel[1], kernel[2], kernel[3], kernel[4], kernel[5]
    for p in range(n):
        n0 = ys1[p] * yt2[p] - ys2[p] * yt1[p]
        n1 = ys2[p] * yt0[p] - ys0[p] * yt2[p]
        n2 = ys0[p] * yt1[p] - ys1[p] * yt0[p]
        r0, r1, r2 = x0 - y0[p], x1 - y1[p], x2 - y2[p]
        square = r0 * r0 + r1 * r1 + r2 * r2
        area = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        inverse = 1.0 / np.sqrt(square if square > tiny else tiny)
        one = weights[p] * area * inverse * (1.0 / EIGHT_PI)
        one = one if square > tiny else 0.0
        three = one * inverse * inverse
        k0[p] = one + three * r0 * r0
        k1[p] = three * r0 * r1
        k2[p] = three * r0 * r2
        k3[p] = one + three * r1 * r1
        k4[p] = three * r1 * r2
        k5[p] = one + three * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def tensor_moments(m, n1, n2, bs, bt, kernel, moments):
    """Sum-factorised moments ``(m * m, 6)`` of kernel values at tensor nodes, s contiguous.

    ``bs (>= n1, m)``, ``bt (>= n2, m)``: functions at the nodes. Six sums side by side hide the
    latency of the additions.
    """
    moments[:] = 0.0
    k0, k1, k2, k3, k4, k5 = kernel[0], kernel[1], kernel[2], kernel[3], kernel[4], kernel[5]
    for q in range(n2):
        for i in range(m):
            a0, a1, a2, a3, a4, a5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(n1):
                p = q * n1 + k
                v = bs[k, i]
                a0 += v * k0[p]
                a1 += v * k1[p]
                a2 += v * k2[p]
                a3 += v * k3[p]
                a4 += v * k4[p]
                a5 += v * k5[p]
            for j in range(m):
                v = bt[q, j]
                line = moments[i * m + j]
                line[0] += v * a0
                line[1] += v * a1
                line[2] += v * a2
                line[3] += v * a3
                line[4] += v * a4
                line[5] += v * a5


@njit(cache=True, error_model="numpy", nogil=True)
def scattered_moments(m, n, bs, bt, kernel, products, moments):
    """Moments ``(m * m, 6)`` of kernel values at n scattered nodes, n a multiple of 4.

    Four points at a time, the ``m * m`` functions as vector; ``products (10, m * m)`` is scratch.
    """
    products[4:] = 0.0
    f0, f1, f2, f3 = products[0], products[1], products[2], products[3]
    for p in range(0, n, 4):
        for k in range(4):
            for i in range(m):
                for j in range(m):
                    products[k, i * m + j] = bs[p + k, i] * bt[p + k, j]
        for c in range(6):
            v0, v1, v2, v3 = kernel[c, p], kernel[c, p + 1], kernel[c, p + 2], kernel[c, p + 3]
            total = products[4 + c]
            for b in range(m * m):
                total[b] += v0 * f0[b] + v1 * f1[b] + (v2 * f2[b] + v3 * f3[b])
    for c in range(6):
        for b in range(m * m):
            moments[b, c] = products[4 + c, b]
