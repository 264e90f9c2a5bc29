"""Compiled evaluation off the surface: velocity, pressure, stress and solid angle at points.

Densities are known, so every integration point adds its share of the fields directly. Elements
far from a point take the plain rule; the pieces near it a tensor rule, ``s = s0 + b sinh(v)`` on
both sides of the closest point. Rows of results: `VELOCITY`, `PRESSURE`, `STRESS`, `ANGLE`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI, stokeslet, stresslet
from ..near._closest_point_kernels import SMALLEST
from ..surfaces._jet_kernels import bernstein

VELOCITY, PRESSURE, STRESS, ANGLE, SIZE = 0, 3, 4, 10, 11
BLOCK = 8  # points that share one set of buffers


@njit(cache=True, error_model="numpy", nogil=True)
def add_single(r, f, a, b, out):
    """A point force ``f``: its velocity ``a f + b r (r . f)``, its pressure and its stress."""
    along = b * (r[0] * f[0] + r[1] * f[1] + r[2] * f[2])
    # the stress -3 r_i r_j (r . f) / 4 pi |r|^5 is a stresslet with the force as its normal
    c = stresslet(OVER_8_PI, r[0], r[1], r[2], f[0], f[1], f[2], 0.0)
    for i in range(3):
        out[VELOCITY + i] += a * f[i] + along * r[i]
    out[PRESSURE] += 2.0 * along
    k = STRESS
    for i in range(3):
        for j in range(i, 3):
            out[k] -= c * r[i] * r[j]
            k += 1


@njit(cache=True, error_model="numpy", nogil=True)
def add_double(r, phi, n, square, b, out):
    """A stresslet of strength phi and normal n, its pressure and stress; ``b = 1/(8 pi r^3)``."""
    along = r[0] * phi[0] + r[1] * phi[1] + r[2] * phi[2]
    flux = r[0] * n[0] + r[1] * n[1] + r[2] * n[2]
    g = phi[0] * n[0] + phi[1] * n[1] + phi[2] * n[2]
    c = along * stresslet(OVER_8_PI, r[0], r[1], r[2], n[0], n[1], n[2], 0.0)
    five = 6.0 * b / square
    seven = -10.0 * c / square
    for i in range(3):
        out[VELOCITY + i] += c * r[i]
    out[PRESSURE] += 2.0 * c - 4.0 * b * g
    k = STRESS
    for i in range(3):
        for j in range(i, 3):
            value = (r[i] * phi[j] + r[j] * phi[i]) * flux + (r[i] * n[j] + r[j] * n[i]) * along
            out[k] += five * value + seven * r[i] * r[j]
            if i == j:
                out[k] += 4.0 * b * g
            k += 1


@njit(cache=True, error_model="numpy", nogil=True)
def add_source(x, y, n, w, f, u, wall, double, r, strength, out):
    """One integration point: force density f, velocity density ``u - wall``, ``n`` with area."""
    for c in range(3):
        r[c] = x[c] - y[c]
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    if square == 0.0:
        return
    size = 0.0
    for c in range(3):
        size += n[c] * n[c]
    size = np.sqrt(size) * w
    for c in range(3):
        strength[0, c] = f[c] * size
        strength[2, c] = n[c] * w
    a, b = stokeslet(OVER_8_PI, r[0], r[1], r[2], 0.0)
    add_single(r, strength[0], a, b, out)
    n0, n1, n2 = strength[2, 0], strength[2, 1], strength[2, 2]
    out[ANGLE] -= 2.0 * b * (r[0] * n0 + r[1] * n1 + r[2] * n2)
    if double != 0.0:
        for c in range(3):
            strength[1, c] = double * (u[c] - wall[c])
        add_double(r, strength[1], strength[2], square, b, out)


@njit(cache=True, error_model="numpy", nogil=True)
def half_line(n, centre, b, end, nodes, weights, x, w):
    """n nodes between ``centre`` and ``end``, clustered about the centre at the scale b."""
    length = np.arcsinh((end - centre) / b)
    for k in range(n):
        v = length * nodes[n, k]
        x[k] = centre + b * np.sinh(v)
        w[k] = abs(b * np.cosh(v) * length * weights[n, k])


@njit(cache=True, error_model="numpy", nogil=True)
def split_line(rule, oblique, centre, b, low, high, nodes, weights, x, w):
    """Nodes on both sides of the closest point; returns their number."""
    b = max(b, SMALLEST * (high - low))
    n = int(np.ceil(oblique * (rule[0] - rule[1] * np.log(min(1.0, b / (high - low))))))
    n = min(max(n, 4), nodes.shape[0] - 1)
    total, edge = 0, 1e-9 * (high - low)
    if centre - low > edge:
        half_line(n, centre, b, low, nodes, weights, x, w)
        total = n
    if high - centre > edge or total == 0:
        half_line(n, centre, b, high, nodes, weights, x[total:], w[total:])
        total += n
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def combine(table_s, table_t, coefficients, out):
    """``out[c] = sum_ij table_s[i] table_t[j] coefficients[i, j, c]``."""
    n = coefficients.shape[0]
    for c in range(out.size):
        total = 0.0
        for i in range(n):
            part = 0.0
            for j in range(n):
                part += table_t[j] * coefficients[i, j, c]
            total += table_s[i] * part
        out[c] = total


@njit(cache=True, error_model="numpy", nogil=True)
def cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", nogil=True)
def density_at(s, t, density, tables, out):
    """Traction and velocity ``out (6,)`` at local coordinates."""
    q = density.shape[0] - 1
    bernstein(q, s, tables[0], tables[1])
    bernstein(q, t, tables[2], tables[3])
    combine(tables[0], tables[2], density, out)


@njit(cache=True, error_model="numpy", nogil=True)
def fields(
    span, points, indptr, elements, found, boxes, control, density, sources, normals, values,
    rule, double, nodes, weights, walls, out,
):  # fmt: skip
    """Fields at points off the surface.

    Parameters
    ----------
    points : (n, 3) array
    indptr, elements, found, boxes :
        Near (point, piece) pairs; ``boxes (n_pairs, 4)`` are the pieces.
    control : (n_elements, g + 1, g + 1, 3) array
    density : (n_elements, q + 1, q + 1, 6) array
        Bernstein coefficients of traction and velocity.
    sources, normals : (n_elements, n_q, 3) array
        Plain points; normals times weight and area.
    values : (n_elements, n_q, 6) array
        Traction and velocity there.
    rule : (2,) tuple
        Offset and slope of the number of nodes on each side.
    double : float
        Factor of the double layer; 0 skips it.
    walls : (n, 3) array
        Velocity subtracted from the double layer's density, by point.
    out : (n, 11) array
        Result, overwritten.
    """
    g, q = control.shape[1] - 1, density.shape[1] - 1
    longest = 2 * nodes.shape[0]
    for block in range(span[0], span[1]):
        near = np.zeros(control.shape[0], np.bool_)
        geometry, tables = np.empty((4, g + 2)), np.empty((4, q + 2))
        xs, ws = np.empty(longest), np.empty(longest)
        xt, wt = np.empty(longest), np.empty(longest)
        y, along_s, along_t = np.empty(3), np.empty(3), np.empty(3)
        n, here, r, strength = np.empty(3), np.empty(6), np.empty(3), np.empty((3, 3))
        for p in range(block * BLOCK, min((block + 1) * BLOCK, points.shape[0])):
            x, row = points[p], out[p]
            row[:] = 0.0
            for k in range(indptr[p], indptr[p + 1]):
                near[elements[k]] = True
            for e in range(sources.shape[0]):
                if near[e]:
                    continue
                for i in range(sources.shape[1]):
                    f = values[e, i]
                    add_source(
                        x, sources[e, i], normals[e, i], 1.0, f[:3], f[3:], walls[p], double, r,
                        strength, row,
                    )  # fmt: skip
            for k in range(indptr[p], indptr[p + 1]):
                e, box = elements[k], boxes[k]
                near[e] = False
                oblique, b1, b2 = found[k, 4], found[k, 2], found[k, 3]
                n1 = split_line(
                    rule, oblique, found[k, 0], b1, box[0], box[1], nodes, weights, xs, ws
                )
                n2 = split_line(
                    rule, oblique, found[k, 1], b2, box[2], box[3], nodes, weights, xt, wt
                )
                for j in range(n2):
                    bernstein(g, xt[j], geometry[2], geometry[3])
                    for i in range(n1):
                        bernstein(g, xs[i], geometry[0], geometry[1])
                        combine(geometry[0], geometry[2], control[e], y)
                        combine(geometry[1], geometry[2], control[e], along_s)
                        combine(geometry[0], geometry[3], control[e], along_t)
                        cross(along_s, along_t, n)
                        density_at(xs[i], xt[j], density[e], tables, here)
                        add_source(
                            x, y, n, ws[i] * wt[j], here[:3], here[3:], walls[p], double, r,
                            strength, row,
                        )  # fmt: skip


@njit(cache=True, error_model="numpy", nogil=True)
def densities(span, elements, found, density, out):
    """Traction and velocity ``out (n, 6)`` at the closest points of pairs."""
    for k in range(span[0], span[1]):
        tables = np.empty((4, density.shape[1] + 1))
        density_at(found[k, 0], found[k, 1], density[elements[k]], tables, out[k])
