"""Compiled near field of the single layer: accurate minus plain moments per (point, element).

A moment is ``int G_c(x, y) B_i(s) B_j(t) dS`` for the six components of the symmetric kernel
``G_ik = (delta_ik / r + r_i r_k / r^3) / 8 pi`` [T 3.10a] in the order 00 01 02 11 12 22. Density
functions are combinations of the ``(q + 1)**2`` moments, formed once per pair.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from ._point_kernels import (
    EIGHT_PI,
    cubic_component,
    general_geometry,
    kernel_points,
    scattered_moments,
    tables,
    tensor_moments,
)
from ._rule_kernels import closest, jet, polar_triangle, sinh_nodes

BLOCK = 16  # points that share one set of buffers
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
        n = polar_triangle(s0, t0, edges[k], (e, f, g), (nr, na), nodes, weights, n, s, t, w)
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

    ``cubic (n_elements, 3, 4, 4)`` holds patches up to degree 3 in powers, or is empty; ``rule``
    is the sinh rule's offset and slope, ``polar`` its radial and angular orders.
    """
    largest = nodes.shape[0] - 1
    m, mg = degree + 1, control.shape[1]
    size = max(largest * largest, 16 * polar[0] * polar[1])
    for block in prange((points.shape[0] + BLOCK - 1) // BLOCK):
        wide = max(m, mg)
        products = np.empty((10, m * m))
        scratch, out = np.empty((6, wide + 1)), np.empty((6, 3))
        s, t, w = np.empty(size), np.empty(size), np.empty(size)
        position, kernel = np.empty((9, size)), np.empty((6, size))
        bs, ds = np.empty((size, wide)), np.empty((size, wide))
        bt, dt = np.empty((size, wide)), np.empty((size, wide))
        line, fine = np.empty((2, largest)), np.empty((2, largest))
        for p in range(block * BLOCK, min((block + 1) * BLOCK, points.shape[0])):
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
