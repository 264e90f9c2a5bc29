"""Near-singular rules and their speed: moments against distance, time by pair and kernel point.

Rows of `airfold bench integrals`.
"""

from __future__ import annotations

import time
from functools import partial
from operator import matmul

import numpy as np
from scipy.sparse import csr_matrix

from hbem.layers.double_layer import double_layer
from hbem.layers.single_layer import single_layer
from hbem.near.closest_point import near_pairs, outer_pairs
from hbem.near.near_field import near_field
from hbem.near.near_rules import Layer, near_moments
from hbem.surfaces.bernstein import tensor_bernstein, tensor_bernstein_gradient
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders, gauss_square
from hbem.surfaces.surface_points import SampledSurface, sample
from hbem.surfaces.triangles import quadrilaterals, triangle_index

from ...geometry.bodies import fitted, torus
from ..report import Row, best

DISTANCES = (1e-1, 1e-2, 1e-3, 1e-4)
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def run(quick: bool) -> list[Row]:
    """All rows of this file."""
    return [*near_rows(quick), *triangle_rows(quick), *speed_rows(quick), *action_rows(quick)]


def coefficients_of(body: BezierPatches) -> np.ndarray:
    """Of a body that was made with its own shape."""
    assert body.coefficients is not None
    return body.coefficients


def subdivided(
    control: np.ndarray, x: np.ndarray, degree: int, layer: Layer, n: int, deepest: float = 1e-7
) -> tuple[np.ndarray, int]:
    """Reference moments by recursive quartering, and the points used."""
    s0, t0, w0 = gauss_square(n)
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    total, todo, used = np.zeros(((degree + 1) ** 2, 6)), [(0.0, 0.0, 1.0)], 0
    while todo:
        a, c, h = todo.pop()
        s, t = a + h * s0, c + h * t0
        ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s, t))
        size = h * max(np.linalg.norm(ys, axis=1).max(), np.linalg.norm(yt, axis=1).max())
        r = x - tensor_bernstein(g, s, t) @ flat
        if np.linalg.norm(r, axis=1).min() < size and h > deepest:
            half = 0.5 * h
            todo += [(a + i * half, c + j * half, half) for i in (0, 1) for j in (0, 1)]
            continue
        used += s.size
        total += tensor_bernstein(degree, s, t).T @ _kernel(r, np.cross(ys, yt), layer, w0 * h * h)
    return total, used


def _kernel(r: np.ndarray, normal: np.ndarray, layer: Layer, w: np.ndarray) -> np.ndarray:
    """Six kernel components with unnormalised normals, ``(n, 6)``."""
    d = np.linalg.norm(r, axis=1)
    if layer is Layer.DOUBLE:
        f = 0.75 / np.pi * w * np.sum(r * normal, axis=1) / d**5
        return np.stack([f * r[:, i] * r[:, k] for i, k in PAIRS], axis=1)
    f = w * np.linalg.norm(normal, axis=1) / (8.0 * np.pi)
    return np.stack([f * ((i == k) / d + r[:, i] * r[:, k] / d**3) for i, k in PAIRS], axis=1)


def near_rows(quick: bool) -> list[Row]:
    """Near-singular moments against distance, beside plain Gauss of equal cost."""
    body = fitted(torus(8, 8))
    surface = sample(body, coefficients_of(body), QuadratureOrders())
    element, rows = 9, []
    control = surface.control[element]
    spots = ((0.4, 0.55), (0.02, 0.5), (0.01, 0.03)) if quick else (
        (0.4, 0.55), (0.8, 0.3), (0.02, 0.5), (0.5, 1.0), (0.01, 0.03), (0.99, 0.98)
    )  # fmt: skip
    for layer in (Layer.SINGLE, Layer.DOUBLE):
        for distance in DISTANCES:
            x = np.stack(
                [_above(control, s, t, distance * side) for s, t in spots for side in (-1, 1)]
            )
            near = near_pairs(surface, x, np.full(len(x), -1), 1.0)
            at = [k for k in range(near.n_pairs) if near.elements[k] == element]
            exact = [subdivided(control, p, 2, layer, 10)[0] for p in x]
            for name, orders in (
                ("default", QuadratureOrders()),
                ("fine", QuadratureOrders.fine()),
            ):
                start = time.perf_counter()
                found = near_moments(surface, near, orders, layer)[at]
                seconds = time.perf_counter() - start
                error = max(_relative(f, e) for f, e in zip(found, exact, strict=True))
                used = _points(near.closest.rows[at], orders, layer)
                n = round(np.sqrt(used))
                plain = max(
                    _relative(_plain(control, p, layer, n), e)
                    for p, e in zip(x, exact, strict=True)
                )
                rows.append(
                    {
                        "case": f"near {layer.name.lower()}",
                        "d/h": distance,
                        "orders": name,
                        "points": used,
                        "error": error,
                        "peer_error": plain,
                        "peer": f"Gauss {n}x{n}",
                        "seconds": seconds,
                        "reference": "adaptive quartering",
                    }
                )
    return rows


def triangle_rows(quick: bool) -> list[Row]:
    """Near-singular moments of a curved triangle against distance.

    Rules contract each triangle at the vertex farthest from the closest point; ``peer`` contracts
    all at the same vertex.
    """
    x = (triangle_index(2) / 2.0)[:, 1:]
    control = np.column_stack([x, 0.25 * (x[:, 0] ** 2 - 0.6 * x[:, 0] * x[:, 1])])
    body = BezierPatches(
        n_dofs=6, geometry_degree=2, density_degree=2, indptr=np.array([0, 6]),
        dofs=np.arange(6), extraction=np.eye(6), bezier=csr_matrix(np.eye(6)),
        coefficients=control, shape="triangle",
    )  # fmt: skip
    fixed = quadrilaterals(body)
    surfaces = [sample(patches, control, QuadratureOrders()) for patches in (body, fixed)]
    # barycentric places: centre, edge, near an edge, beside each vertex
    places = [[1, 1, 1], [0, 1, 1], [4, 1, 0.1], [18, 1, 1], [1, 18, 1], [1, 1.1, 18]]
    places += [] if quick else [[1, 20, 0.01], [5, 3, 0], [10, 3, 20], [10, 20, 3]]
    spots = np.array(places, float)
    spots /= spots.sum(axis=1, keepdims=True)
    rows = []
    for layer in (Layer.SINGLE, Layer.DOUBLE):
        for distance in DISTANCES:
            # x on the square: u = 1 - s, v = s (1 - t), w = s t
            points = np.stack(
                [
                    _above(surfaces[0].control[0], 1.0 - u, w / (v + w), side * distance)
                    for u, v, w in spots
                    for side in (-1.0, 1.0)
                ]
            )
            exact = np.stack(
                [
                    fixed.extraction @ subdivided(surfaces[0].control[0], p, 2, layer, 10, 1e-6)[0]
                    for p in points
                ]
            )
            size = np.abs(exact).max(axis=(1, 2))
            for name, orders in (
                ("default", QuadratureOrders()),
                ("fine", QuadratureOrders.fine()),
            ):
                start = time.perf_counter()
                found = [_triangle_moments(s, points, orders, layer) for s in surfaces]
                seconds = time.perf_counter() - start
                error, peer = (
                    float((np.abs(f - exact).max(axis=(1, 2)) / size).max()) for f in found
                )
                rows.append(
                    {
                        "case": f"triangle {layer.name.lower()}", "d/h": distance, "orders": name,
                        "error": error, "peer_error": peer, "peer": "vertex 0 of all",
                        "seconds": 0.5 * seconds, "reference": "adaptive quartering",
                    }
                )  # fmt: skip
    return rows


def _triangle_moments(
    surface: SampledSurface, x: np.ndarray, orders: QuadratureOrders, layer: Layer
) -> np.ndarray:
    """Moments of the first triangle's functions at all points, ``(n, n_functions, 6)``."""
    near = near_pairs(surface, x, np.full(len(x), -1), 1.0)
    moments = near_moments(surface, near, orders, layer)
    sums = np.zeros((len(x), *moments.shape[1:]))
    np.add.at(sums, np.repeat(np.arange(len(x)), np.diff(near.indptr)), moments)
    return np.einsum("ab,nbc->nac", surface.patches.extraction, sums)


def _above(control: np.ndarray, s: float, t: float, distance: float) -> np.ndarray:
    """Point at a distance, in units of the element, above ``(s, t)``."""
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    s_, t_ = np.array([s]), np.array([t])
    ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s_, t_))
    normal = np.cross(ys, yt)[0]
    area = np.linalg.norm(normal)
    return (tensor_bernstein(g, s_, t_) @ flat)[0] + distance * np.sqrt(area) * normal / area


def _relative(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def _plain(control: np.ndarray, x: np.ndarray, layer: Layer, n: int) -> np.ndarray:
    s, t, w = gauss_square(n)
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s, t))
    r = x - tensor_bernstein(g, s, t) @ flat
    return tensor_bernstein(2, s, t).T @ _kernel(r, np.cross(ys, yt), layer, w)


def _points(found: np.ndarray, orders: QuadratureOrders, layer: Layer) -> int:
    """Mean kernel points of a pair."""
    offset, slope = orders.rule(layer)
    n = np.clip(np.ceil(found[:, 4:] * (offset - slope * np.log(found[:, 2:4]))), 4, 48)
    if layer is Layer.DOUBLE:
        n = n * (1 + ((found[:, :2] > 1e-9) & (found[:, :2] < 1 - 1e-9)))
    return int(np.prod(n, axis=1).mean())


def speed_rows(quick: bool) -> list[Row]:
    """Near field of V and K: seconds, per pair and per kernel point."""
    rows = []
    sizes = ((20, 20),) if quick else ((20, 20), (50, 100))
    for n_s, n_t in sizes:
        for degree in (2, 3):
            body = fitted(torus(n_s, n_t, degree=degree))
            surface = sample(body, coefficients_of(body), QuadratureOrders())
            orders = QuadratureOrders()
            near = outer_pairs(surface, orders, slice(0, surface.outer.points.shape[0]))
            own = near.closest.rows[:, 2] < 0.0
            for layer in (Layer.SINGLE, Layer.DOUBLE):
                split = _points(near.closest.rows[~own], orders, layer)
                points = (~own).sum() * split + own.sum() * 4 * orders.radial * orders.angular
                moments = best(
                    partial(near_moments, surface, near, orders, layer, minus_plain=True)
                )
                whole = moments
                if layer is Layer.SINGLE:
                    whole = best(partial(near_field, surface, orders))
                rows.append(
                    {
                        "case": f"speed {layer.name.lower()}",
                        "elements": n_s * n_t,
                        "degree": degree,
                        "pairs": near.n_pairs,
                        "points_a_pair": points / near.n_pairs,
                        "seconds": whole,
                        "moments_s": moments,
                        "us_a_pair": 1e6 * moments / near.n_pairs,
                        "ns_a_point": 1e9 * moments / points,
                        "error": 0.0,
                        "error_kind": "timing",
                        "reference": "-",
                    }
                )
    return rows


def action_rows(quick: bool) -> list[Row]:
    """K applied to a known velocity beside V applied to a traction, at equal points."""
    rows = []
    for n in (20,) if quick else (20, 40):
        body = fitted(torus(n, n))
        single = single_layer(body, coefficients_of(body), storage="direct")
        double = double_layer(single.surface, QuadratureOrders())
        x = np.random.default_rng(0).standard_normal(single.shape[0])
        v, k = best(partial(matmul, single, x)), best(partial(matmul, double, x))
        rows.append(
            {
                "case": "action of K", "elements": n * n, "seconds": k, "peer": "action of V",
                "peer_seconds": v, "ratio": k / v, "error": double.gauss_error,
                "error_kind": "defect of the Gauss identity", "reference": "-",
            }
        )  # fmt: skip
    return rows
