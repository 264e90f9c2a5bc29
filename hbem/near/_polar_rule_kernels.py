"""Compiled polar rule of points on their own elements, `LANES` pairs side by side.

Triangles between the point and the edges of its piece, in the tangent plane's metric, with
``u = asinh(tau / height)`` as angle: points near an edge cost nothing. The factor rho of the polar
surface element cancels the singularity.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..surfaces._jet_kernels import jet
from ._patch_lane_kernels import LANES, exponentials, lane, node_table, row_polynomials
from ._vector_kernels import add_points, point_values

EDGES = ((0, 2, 1, 2), (1, 2, 1, 3), (1, 3, 0, 3), (0, 3, 0, 2))  # ends of each edge in a box
RAY = 9  # numbers that describe a triangle: see `triangle`


@njit(cache=True, error_model="numpy", nogil=True)
def metric(powers, control, s, t, scratch, out):
    """First fundamental form E, F, G at a point."""
    jet(powers, control, s, t, scratch, out)
    e, f, g = 0.0, 0.0, 0.0
    for c in range(3):
        e += out[1, c] * out[1, c]
        f += out[1, c] * out[2, c]
        g += out[2, c] * out[2, c]
    return e, f, g


@njit(cache=True, error_model="numpy", nogil=True)
def triangle(s, t, box, edge, form, x, rays):
    """Triangle between ``(s, t)`` and one edge of the box at lane x: ``rays (RAY, LANES)``.

    Corner from the point, edge vector, distance along the edge, height, length, range of u.
    """
    e, f, g = form
    start, along = (box[edge[0]] - s, box[edge[1]] - t), (0.0, 0.0)
    along = (box[edge[2]] - box[edge[0]], box[edge[3]] - box[edge[1]])
    area = np.sqrt(max(e * g - f * f, 1e-300))
    length = np.sqrt(
        e * along[0] * along[0] + 2.0 * f * along[0] * along[1] + g * along[1] * along[1]
    )
    inner = e * start[0] * along[0] + g * start[1] * along[1]
    inner = (inner + f * (start[0] * along[1] + start[1] * along[0])) / length
    height = abs(start[0] * along[1] - start[1] * along[0]) * area / length
    low, span = 0.0, 0.0
    if height > 1e-9 * length:
        low = np.arcsinh(inner / height)
        span = np.arcsinh((inner + length) / height) - low
    line = (
        start[0], start[1], along[0] / length, along[1] / length, inner, height, low, span,
        height * height * span / area,
    )  # fmt: skip
    for k in range(RAY):
        rays[k * LANES + x] = line[k]


@njit(cache=True, error_model="numpy", nogil=True)
def direction(rays, node, weight, ray):
    """Ray of every lane at one angle node: ``ray (3, LANES)`` is its end and its weight."""
    n = LANES
    for x in range(LANES):
        ray[x] = rays[6 * n + x] + rays[7 * n + x] * node
    exponentials(ray[:n], ray[2 * n :])
    for x in range(LANES):
        growth = ray[2 * n + x]
        at = 0.5 * rays[5 * n + x] * (growth - 1.0 / growth) - rays[4 * n + x]
        ray[x] = rays[x] + at * rays[2 * n + x]
        ray[n + x] = rays[n + x] + at * rays[3 * n + x]
        ray[2 * n + x] = 0.5 * (growth + 1.0 / growth) * rays[8 * n + x] * weight


@njit(cache=True, error_model="numpy", nogil=True)
def on_ray(rho, weight, origin, ray, spot):
    """Point of every lane's ray: ``spot (4, LANES)`` is s, t, the weight and one."""
    n = LANES
    for x in range(LANES):
        spot[x], spot[n + x] = origin[x] + rho * ray[x], origin[n + x] + rho * ray[n + x]
        spot[2 * n + x] = 4.0 * rho * weight * ray[2 * n + x]
        spot[3 * n + x] = 1.0


@njit(cache=True, error_model="numpy", nogil=True)
def polar_pass(
    form, nr, na, shape, origin, rays, nodes, weights, tiny, ray, spot, s, t, row, values, moments
):
    """Add the polar rule of one triangle a lane to ``moments (m, m, 6, LANES)``."""
    size = (len(form[1]) + 1) * LANES
    for a in range(na):
        direction(rays, nodes[na, a], weights[na, a], ray)
        for k in range(0, nr, 2):
            for z in range(2):  # beyond the last node the tables hold zeros
                on_ray(nodes[nr, k + z], weights[nr, k + z], origin, ray, spot)
                at_s, at_t = s[z * size : (z + 1) * size], t[z * size : (z + 1) * size]
                node_table(form, lane(spot, 0), lane(spot, 2), at_s)
                node_table(form, lane(spot, 1), lane(spot, 3), at_t)
                row_polynomials(form, shape, lane(at_t, 0), row)
                part = values[6 * z * LANES : 6 * (z + 1) * LANES]
                point_values(form, row, lane(at_s, 0), tiny, part)
            add_points(form, values, s, t, moments)
