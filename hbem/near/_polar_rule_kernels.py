"""Compiled polar rule of points on their own elements, `LANES` pairs side by side.

Triangles between the point and the edges of its piece, in the tangent plane's metric, with
``u = asinh(tau / height)`` as angle: points near an edge cost nothing. The factor rho of the polar
surface element cancels the singularity.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._closest_point_kernels import jet
from ._patch_lane_kernels import LANES, bernstein_lanes, lane, row_polynomials
from ._vector_kernels import add_node, add_nodes, kernel_values, products

EDGES = ((0, 2, 1, 2), (1, 2, 1, 3), (1, 3, 0, 3), (0, 3, 0, 2))  # ends of each edge in a box
RAY = 9  # numbers that describe a triangle: see `triangle`


@njit(cache=True, error_model="numpy", nogil=True)
def metric(control, s, t, scratch, out):
    """First fundamental form E, F, G at a point."""
    jet(control, s, t, scratch, out)
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
        growth = np.exp(rays[6 * n + x] + rays[7 * n + x] * node)
        at = 0.5 * rays[5 * n + x] * (growth - 1.0 / growth) - rays[4 * n + x]
        ray[x] = rays[x] + at * rays[2 * n + x]
        ray[n + x] = rays[n + x] + at * rays[3 * n + x]
        ray[2 * n + x] = 0.5 * (growth + 1.0 / growth) * rays[8 * n + x] * weight


@njit(cache=True, error_model="numpy", nogil=True)
def on_ray(rho, weight, origin, ray, spot):
    """Point of every lane's ray: ``spot (5, LANES)`` is s, t, 2 s - 1, 2 t - 1 and the weight."""
    n = LANES
    for x in range(LANES):
        s, t = origin[x] + rho * ray[x], origin[n + x] + rho * ray[n + x]
        spot[x], spot[n + x] = s, t
        spot[2 * n + x], spot[3 * n + x] = 2.0 * s - 1.0, 2.0 * t - 1.0
        spot[4 * n + x] = 4.0 * rho * weight * ray[2 * n + x]


@njit(cache=True, error_model="numpy", nogil=True)
def polar_pass(
    nr, na, g, degree, layer, target, shape, origin, rays, nodes, weights, tiny, ray, spot, bs, bt,
    row, place, kernel, values, one, moments,
):  # fmt: skip
    """Add the polar rule of one triangle a lane to ``moments (m, m, 6, LANES)``, m = degree + 1.

    ``origin (2, LANES)`` are the points' local coordinates; ``one`` holds ones; what stands
    between `tiny` and `one` is scratch.
    """
    m = degree + 1
    wide, many = 6 * LANES, m * m * LANES
    for a in range(na):
        direction(rays, nodes[na, a], weights[na, a], ray)
        for first in range(0, nr, 4):
            count = min(4, nr - first)
            for z in range(count):
                on_ray(nodes[nr, first + z], weights[nr, first + z], origin, ray, spot)
                row_polynomials(g, shape, lane(spot, 3), row)
                kernel_values(
                    g, layer, target, row, lane(spot, 2), lane(spot, 4), one, tiny, place,
                    kernel[z * wide : (z + 1) * wide],
                )  # fmt: skip
                bernstein_lanes(degree, lane(spot, 0), bs)
                bernstein_lanes(degree, lane(spot, 1), bt)
                products(m, bs, bt, values[z * many : (z + 1) * many])
            if count == 4:
                add_nodes(m * m, values, kernel, moments)
            else:
                for z in range(count):
                    add_node(
                        m * m,
                        values[z * many : (z + 1) * many],
                        kernel[z * wide : (z + 1) * wide],
                        moments,
                    )
