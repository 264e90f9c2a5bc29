"""The two kernels of Stokes flow: written here once (`near/_vector_kernels` excepted, for speed).

    Stokeslet  G_ik = (delta_ik / |r| + r_i r_k / |r|^3) / 8 pi    [T 3.10a]
    stresslet  T_ik = 6 r_i r_k (r . n) / |r|^5 / 8 pi             [T 3.10b]

with ``r = x - y`` from the source y to the target x. The functions are inlined by the compiler;
their numbers have the precision of their arguments, single or double. Numba's cache on disk does
not see that a called function changed in another file: delete `__pycache__` after a change here.
"""

from __future__ import annotations

import numpy as np
from numba import njit

OVER_8_PI = 1.0 / (8.0 * np.pi)


@njit(cache=True, error_model="numpy", nogil=True)
def stokeslet(strength, r0, r1, r2, tiny):
    """``8 pi strength G = a I + b r r^T``: a and b, zero where ``|r|^2 <= tiny``."""
    square = r0 * r0 + r1 * r1 + r2 * r2
    inverse = type(square)(1.0) / np.sqrt(square if square > tiny else tiny)
    a = strength * inverse if square > tiny else type(square)(0.0)
    return a, a * inverse * inverse


@njit(cache=True, error_model="numpy", nogil=True)
def stresslet(strength, r0, r1, r2, n0, n1, n2, tiny):
    """``8 pi strength T = c r r^T``: the number c, zero where ``|r|^2 <= tiny``."""
    square = r0 * r0 + r1 * r1 + r2 * r2
    inverse = type(square)(1.0) / (square if square > tiny else tiny)
    flux = (r0 * n0 + r1 * n1 + r2 * n2) * (type(square)(6.0) * strength)
    c = flux * inverse * inverse * np.sqrt(inverse)
    return c if square > tiny else type(square)(0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def stokeslet_components(strength, x, y, tiny, out):
    """``8 pi strength G``, components 00 01 02 11 12 22, between targets and one source.

    ``x (3, n)`` targets, ``y (3,)``, ``out (6, n)``.
    """
    x0, x1, x2 = x[0], x[1], x[2]
    y0, y1, y2 = y[0], y[1], y[2]
    k0, k1, k2, k3, k4, k5 = out[0], out[1], out[2], out[3], out[4], out[5]
    for t in range(x0.size):
        r0, r1, r2 = x0[t] - y0, x1[t] - y1, x2[t] - y2
        a, b = stokeslet(strength, r0, r1, r2, tiny)
        k0[t] = a + b * r0 * r0
        k1[t] = b * r0 * r1
        k2[t] = b * r0 * r2
        k3[t] = a + b * r1 * r1
        k4[t] = b * r1 * r2
        k5[t] = a + b * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def stresslet_components(strength, x, y, n, tiny, out):
    """The same of ``8 pi strength T``, n (3,) the normal at the source."""
    x0, x1, x2 = x[0], x[1], x[2]
    y0, y1, y2 = y[0], y[1], y[2]
    n0, n1, n2 = n[0], n[1], n[2]
    k0, k1, k2, k3, k4, k5 = out[0], out[1], out[2], out[3], out[4], out[5]
    for t in range(x0.size):
        r0, r1, r2 = x0[t] - y0, x1[t] - y1, x2[t] - y2
        c = stresslet(strength, r0, r1, r2, n0, n1, n2, tiny)
        k0[t] = c * r0 * r0
        k1[t] = c * r0 * r1
        k2[t] = c * r0 * r2
        k3[t] = c * r1 * r1
        k4[t] = c * r1 * r2
        k5[t] = c * r2 * r2


@njit(cache=True, error_model="numpy", nogil=True)
def kernel_line(strength, x, y, normals, tiny, out):
    """``8 pi strength G``, all nine components, between one point and n others.

    ``y (3, n)``; ``out (3, 3 n)`` has row a, column ``b n + j``. With ``normals (3, n)`` at the
    points y instead of ``(3, 0)``: ``8 pi strength T``. Where x is the source and its normal is
    m, hand over ``-m`` as ``normals (3, 1)``: r has the other sign, and T is odd in r.
    """
    n = y.shape[1]
    x0, x1, x2 = x[0], x[1], x[2]
    y0, y1, y2 = y[0], y[1], y[2]
    k0, k1, k2 = out[0], out[1], out[2]
    if normals.shape[1] == 0:
        for j in range(n):
            r0, r1, r2 = x0 - y0[j], x1 - y1[j], x2 - y2[j]
            a, b = stokeslet(strength, r0, r1, r2, tiny)
            k0[j] = a + b * r0 * r0
            k0[n + j] = b * r0 * r1
            k0[2 * n + j] = b * r0 * r2
            k1[n + j] = a + b * r1 * r1
            k1[2 * n + j] = b * r1 * r2
            k2[2 * n + j] = a + b * r2 * r2
    else:
        lone = normals.shape[1] == 1
        for j in range(n):
            k = 0 if lone else j
            r0, r1, r2 = x0 - y0[j], x1 - y1[j], x2 - y2[j]
            c = stresslet(strength, r0, r1, r2, normals[0, k], normals[1, k], normals[2, k], tiny)
            k0[j] = c * r0 * r0
            k0[n + j] = c * r0 * r1
            k0[2 * n + j] = c * r0 * r2
            k1[n + j] = c * r1 * r1
            k1[2 * n + j] = c * r1 * r2
            k2[2 * n + j] = c * r2 * r2
    for j in range(n):
        k1[j] = k0[n + j]
        k2[j] = k0[2 * n + j]
        k2[n + j] = k1[2 * n + j]
