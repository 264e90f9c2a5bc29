"""Compiled near field of the single layer: accurate minus plain moments per (point, element).

A moment is ``int G_c(x, y) B_i(s) B_j(t) dS`` for the six components of the symmetric kernel
``G_ik = (delta_ik / r + r_i r_k / r^3) / 8 pi`` [T 3.10a] in the order 00 01 02 11 12 22. Density
functions are combinations of the ``(q + 1)**2`` moments, formed once per pair.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from ._rule_kernels import bernstein, closest, jet, polar_triangle, sinh_nodes

EIGHT_PI = 8.0 * np.pi
SELF = -1.0  # marks the pair of a point with its own element


@njit(cache=True, error_model="numpy", nogil=True, parallel=True)
def classify(points, owners, indptr, elements, control, starts, st, radii, found):
    """Closest points of candidate pairs.

    ``starts (n_elements, n_q, 3)`` are points of each element at local ``st (2, n_q)``.
    ``found (n_pairs, 4)`` receives s, t, b1, b2 with ``b_i = d / |x_i|``; the target's own
    element receives `SELF` in the last two.
    """
    for p in prange(points.shape[0]):
        scratch = np.empty((6, control.shape[1] + 1))
        out = np.empty((6, 3))
        r = np.empty(3)
        x = points[p]
        for k in range(indptr[p], indptr[p + 1]):
            e = elements[k]
            best, at = 1e300, 0
            for q in range(starts.shape[1]):
                d0 = starts[e, q, 0] - x[0]
                d1 = starts[e, q, 1] - x[1]
                d2 = starts[e, q, 2] - x[2]
                square = d0 * d0 + d1 * d1 + d2 * d2
                # ties go to the first point even after rounding: rotated scenes stay equal
                if square < (1.0 - 1e-9) * best:
                    best, at = square, q
            s, t = st[0, at], st[1, at]
            if owners[p] == e:
                found[k, 0], found[k, 1] = s, t
                found[k, 2], found[k, 3] = SELF, SELF
                continue
            s, t, d = closest(control[e], x, s, t, scratch, out, r)
            found[k, 0], found[k, 1] = s, t
            for i in range(2):
                size = np.sqrt(out[1 + i, 0] ** 2 + out[1 + i, 1] ** 2 + out[1 + i, 2] ** 2)
                # the floor: at a collapsed point |x_s| = 0, and d / |x_s| would call it far
                found[k, 2 + i] = d / max(size, 0.5 * radii[e])


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
def polar_points(s0, t0, control, nr, na, nodes, weights, scratch, out, s, t, w):
    """Polar rule of a whole element about its inner point; returns the number of points."""
    jet(control, s0, t0, scratch, out)
    e, f, g = 0.0, 0.0, 0.0
    for c in range(3):
        e += out[1, c] * out[1, c]
        f += out[1, c] * out[2, c]
        g += out[2, c] * out[2, c]
    n = 0
    edges = (
        (0.0, 0.0, 1.0, 0.0),
        (1.0, 0.0, 1.0, 1.0),
        (1.0, 1.0, 0.0, 1.0),
        (0.0, 1.0, 0.0, 0.0),
    )
    for k in range(4):
        n = polar_triangle(
            s0, t0, edges[k], (e, f, g), (nr, na), nodes, weights, n, s, t, w
        )
    return n


@njit(cache=True, error_model="numpy", nogil=True)
def order(offset, slope, b, largest):
    """Number of sinh nodes at relative distance b."""
    n = int(np.ceil(offset - slope * np.log(b)))
    return min(max(n, 4), largest)


@njit(cache=True, error_model="numpy", nogil=True, parallel=True)
def near_moments(
    points, indptr, elements, found, control, cubic, collapsed, degree, rule, polar, nodes, weights,
    tiny, moments,
):  # fmt: skip
    """Accurate moments ``(n_pairs, (degree + 1)**2, 6)`` of near pairs.

    ``cubic (n_elements, 3, 4, 4)`` holds patches up to degree 3 in powers, or is empty; ``rule`` is the sinh rule's offset and slope, ``polar`` its radial and angular orders.
    """
    largest = nodes.shape[0] - 1
    m, mg = degree + 1, control.shape[1]
    size = max(largest * largest, 16 * polar[0] * polar[1])
    for p in prange(points.shape[0]):
        wide = max(m, mg)
        products = np.empty((10, m * m))
        scratch, out = np.empty((6, wide + 1)), np.empty((6, 3))
        s, t, w = np.empty(size), np.empty(size), np.empty(size)
        position, kernel = np.empty((9, size)), np.empty((6, size))
        bs, ds = np.empty((size, wide)), np.empty((size, wide))
        bt, dt = np.empty((size, wide)), np.empty((size, wide))
        line, fine = np.empty((2, largest)), np.empty((2, largest))
        for k in range(indptr[p], indptr[p + 1]):
            e = elements[k]
            b1, b2 = found[k, 2], found[k, 3]
            n1, n2 = 0, 0
            if b1 < 0.0:
                double = 2 if collapsed[e] else 1
                n = polar_points(
                    found[k, 0], found[k, 1], control[e], double * polar[0], double * polar[1],
                    nodes, weights, scratch, out, s, t, w,
                )  # fmt: skip
            else:
                n1 = order(rule[0], rule[1], b1, largest)
                n2 = order(rule[0], rule[1], b2, largest)
                sinh_nodes(n1, found[k, 0], b1, nodes, weights, line[0], fine[0])
                sinh_nodes(n2, found[k, 1], b2, nodes, weights, line[1], fine[1])
                n = n1 * n2
                for j in range(n2):
                    for i in range(n1):
                        s[j * n1 + i] = line[0, i]
                        t[j * n1 + i] = line[1, j]
                        w[j * n1 + i] = fine[0, i] * fine[1, j]
            if cubic.shape[0] > 0:
                for c in range(3):
                    y, ys, yt = position[3 * c], position[3 * c + 1], position[3 * c + 2]
                    cubic_component(cubic[e, c], n, s, t, y, ys, yt)
            else:
                tables(mg - 1, n, s, bs, ds)
                tables(mg - 1, n, t, bt, dt)
                general_geometry(control[e], n, bs, ds, bt, dt, position)
            kernel_points(points[p], tiny, n, position, w, kernel)
            if b1 < 0.0:
                tables(m - 1, n, s, bs, ds)
                tables(m - 1, n, t, bt, dt)
                scattered_moments(m, n, bs, bt, kernel, products, moments[k])
            else:
                tables(m - 1, n1, line[0], bs, ds)
                tables(m - 1, n2, line[1], bt, dt)
                tensor_moments(m, n1, n2, bs, bt, kernel, moments[k])


@njit(cache=True, error_model="numpy", nogil=True, parallel=True)
def subtract_plain(points, indptr, elements, sources, weights, basis, tiny, moments):
    """Subtract the plain rule of near pairs, as the far field will add it back.

    ``sources (n_elements, n_q, 3)``, ``weights (n_elements, n_q)``, ``basis (n_q, nb)``.
    """
    nq, nb = basis.shape
    for p in prange(points.shape[0]):
        for k in range(indptr[p], indptr[p + 1]):
            e = elements[k]
            for q in range(nq):
                r0 = points[p, 0] - sources[e, q, 0]
                r1 = points[p, 1] - sources[e, q, 1]
                r2 = points[p, 2] - sources[e, q, 2]
                square = r0 * r0 + r1 * r1 + r2 * r2
                if square <= tiny:
                    continue
                inverse = 1.0 / np.sqrt(square)
                one = weights[e, q] * inverse * (1.0 / EIGHT_PI)
                three = one * inverse * inverse
                values = (
                    one + three * r0 * r0,
                    three * r0 * r1,
                    three * r0 * r2,
                    one + three * r1 * r1,
                    three * r1 * r2,
                    one + three * r2 * r2,
                )
                for b in range(nb):
                    for c in range(6):
                        moments[k, b, c] -= values[c] * basis[q, b]
