"""Accuracy and speed of the boundary integrals: exact flows, near-singular rules, assembly.

``ROWS`` lists the row functions; each takes ``quick`` and returns rows. Errors of tractions are
relative in L2 against exact solutions; ``best`` is the best approximation in the same space.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from hbem.closest_point import near_pairs, outer_pairs
from hbem.double_layer import double_layer
from hbem.krylov import DenseSaddle
from hbem.near import Layer, near_moments
from hbem.near_field import near_field
from hbem.patches import BezierPatches, tensor_bernstein, tensor_bernstein_gradient
from hbem.point_sums import single_layer_sums
from hbem.quadrature import QuadratureOrders, gauss_square
from hbem.sampling import SampledSurface, sample
from hbem.single_layer import single_layer
from hbem.stokes import jump_data, needs_double_layer

from ..geometry.bodies import fitted, sphere, spheroid, torus
from . import gaps

Row = dict[str, Any]
Flow = tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray, np.ndarray], np.ndarray]]
STRAIN = np.array([[1.0, 0.5, 0.0], [0.5, -2.0, 0.3], [0.0, 0.3, 1.0]])
AXIS = np.array([0.0, 0.0, 1.0])
DISTANCES = (1e-1, 1e-2, 1e-3, 1e-4)
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def run(quick: bool) -> list[Row]:
    """All rows; ``quick`` leaves out the larger meshes."""
    return [row for rows in ROWS for row in rows(quick)]


def pairs() -> int:
    """Calibration: plain point sums."""
    x = np.random.default_rng(0).standard_normal((4096, 3))
    single_layer_sums(x, x, x)
    return x.shape[0] ** 2


def shear(x: np.ndarray) -> np.ndarray:
    return np.stack([x[:, 2], 0.0 * x[:, 0], 0.0 * x[:, 0]], axis=1)


def shear_traction(x: np.ndarray, n: np.ndarray) -> np.ndarray:
    return np.stack([n[:, 2], 0.0 * n[:, 0], n[:, 0]], axis=1)


def lubrication(h: float) -> Flow:
    """Polynomial flow of a thin gap [T theorem 40], exact in any closed body."""

    def velocity(x: np.ndarray) -> np.ndarray:
        r, z = x[:, :2], x[:, 2:]
        return np.hstack([r * (h * h - z**2), 2.0 * z * (z**2 / 3.0 - h * h)])

    def traction(x: np.ndarray, n: np.ndarray) -> np.ndarray:
        z, p = x[:, 2], 2.0 * x[:, 2] ** 2 - x[:, 0] ** 2 - x[:, 1] ** 2
        a = h * h - z**2
        shear = -2.0 * z * n[:, 2]
        planar = x[:, :2] * shear[:, None] + 2.0 * a[:, None] * n[:, :2]
        third = -2.0 * z * (x[:, 0] * n[:, 0] + x[:, 1] * n[:, 1]) - 4.0 * a * n[:, 2]
        return np.hstack([planar, third[:, None]]) - p[:, None] * n

    return velocity, traction


def traction_errors(
    body: BezierPatches,
    flow: Flow,
    ratio: float,
    orders: QuadratureOrders | None = None,
    norm: int = 5,
) -> tuple[float, float, float, float]:
    """Error, best approximation, zeta and seconds of the traction jump of an exact flow."""
    orders = QuadratureOrders() if orders is None else orders
    start = time.perf_counter()
    layer = single_layer(body, body.coefficients, orders, storage="dense")
    surface = layer.surface
    data = surface.project(flow[0](surface.outer.points))
    double, projected = None, None
    if needs_double_layer(ratio):
        double = double_layer(surface, orders)
        projected = splu(surface.mass.tocsc()).solve(data).ravel()
    rhs = jump_data(data.ravel(), ratio, double, projected)
    solved = DenseSaddle(layer, surface.constraint, surface.mass).solve(rhs)
    seconds = time.perf_counter() - start
    fine = sample(body, body.coefficients, QuadratureOrders(outer=norm))
    exact = without_pressure(fine, flow[1](fine.outer.points, fine.outer.normals))
    best = fine.basis @ splu(fine.mass.tocsc()).solve(fine.project(exact))
    tau = fine.basis @ solved.solution.reshape(-1, 3)
    size = norm_of(fine, exact)
    error, smallest = norm_of(fine, tau - exact) / size, norm_of(fine, best - exact) / size
    return error, smallest, float(solved.zeta), seconds


def without_pressure(surface: SampledSurface, tau: np.ndarray) -> np.ndarray:
    """A traction without its constant pressure: the system fixes it as ``<tau, n> = 0``."""
    normals, weights = surface.outer.normals, surface.outer.weights
    return tau - normals * (weights @ np.sum(tau * normals, axis=1)) / weights.sum()


def norm_of(surface: SampledSurface, values: np.ndarray) -> float:
    return float(np.sqrt(surface.outer.weights @ np.sum(values**2, axis=1)))


def _traction_row(case: str, body, flow, ratio, orders=None, **parameters: Any) -> Row:
    error, best, zeta, seconds = traction_errors(body, flow, ratio, orders)
    return {
        "case": case, **parameters, "error": error, "best": best, "over_best": error / best,
        "zeta": zeta, "seconds": seconds, "reference": "exact solution",
    }  # fmt: skip


def torus_rows(quick: bool) -> list[Row]:
    """Shear flow inside a torus [T 6.3.2], exact and fitted geometry; rate between meshes."""
    rows: list[Row] = []
    for degree in (2, 3):
        for geometry in ("degree 8", "isogeometric"):
            last = None
            for n in (4, 5, 8) if quick else (4, 5, 8, 11, 16):
                body = torus(n, n, degree=degree)
                body = body if geometry == "degree 8" else fitted(body)
                row = _traction_row(
                    "torus shear", body, (shear, shear_traction), 0.0,
                    degree=degree, geometry=geometry, n=n,
                )  # fmt: skip
                rate = np.log(last[1] / row["error"]) / np.log(n / last[0]) if last else np.nan
                last = n, row["error"]
                rows.append({**row, "rate": float(rate)})
    return rows


def sphere_rows(quick: bool) -> list[Row]:
    """Translation, rotation, strain for every kind of viscosity ratio."""
    rows, n = [], 6 if quick else 8
    for ratio in (0.0, 0.3, 1.0, 3.0):
        flows = {"strain": (lambda x: x @ STRAIN, lambda x, m, f=2 + 3 * ratio: f * m @ STRAIN)}
        if ratio > 0.0:
            flows["rotation"] = (
                lambda x: np.cross(AXIS, x),
                lambda x, m, f=3 * ratio: f * np.cross(AXIS, m),
            )
            flows["translation"] = (
                lambda x: 0.0 * x + AXIS,
                lambda x, m, f=1.5 * ratio: 0.0 * x + f * AXIS,
            )
        for name, flow in flows.items():
            row = _traction_row(
                f"sphere {name}", sphere(n, n), flow, ratio, n=n, viscosity_ratio=ratio
            )
            rows.append({**row, "over_best": row["over_best"] if row["best"] > 1e-9 else np.nan})
    return rows


def order_rows(quick: bool) -> list[Row]:
    """Outer and inner orders: error of the matrix' traction against time, the knee."""
    rows, n = [], 6 if quick else 8
    flow = (shear, shear_traction)
    for degree in (2, 3):
        for outer in (2, 3, 4):
            for name, base in (("default", QuadratureOrders()), ("fine", QuadratureOrders.fine())):
                orders = QuadratureOrders(**{**vars(base), "outer": outer, "far": max(outer, 3)})
                body = torus(n, n, degree=degree)
                rows.append(
                    _traction_row(
                        "orders", body, flow, 0.0, orders, degree=degree, outer=outer, inner=name
                    )
                )
    return rows


def eigenvalue_rows(quick: bool) -> list[Row]:
    """Smallest eigenvalue of V against the mass matrix on the complement of n: positive."""
    rows = []
    for name, body in (("sphere", sphere(6, 6)), ("torus", torus(6, 6))):
        start = time.perf_counter()
        layer = single_layer(body, body.coefficients, storage="dense")
        factor = np.linalg.cholesky(layer.surface.mass.toarray())
        inverse = np.kron(np.linalg.inv(factor), np.eye(3))
        scaled = inverse @ layer.dense() @ inverse.T
        normal = inverse @ layer.surface.constraint.ravel()
        keep = np.eye(normal.size) - np.outer(normal, normal) / (normal @ normal)
        values = np.linalg.eigvalsh(0.5 * keep @ (scaled + scaled.T) @ keep)
        # the zero of the projected normal is removed by its size
        values = np.delete(values, np.argmin(np.abs(values)))
        asymmetry = np.linalg.norm(scaled - scaled.T) / np.linalg.norm(scaled)
        rows.append(
            {
                "case": "smallest eigenvalue",
                "body": name,
                "value": values[0],
                "largest": values[-1],
                "error": asymmetry,
                "error_kind": "asymmetry",
                "seconds": time.perf_counter() - start,
                "reference": "positive [T 3.3]",
            }
        )
    return rows


def gap_rows(quick: bool) -> list[Row]:
    """Thin-gap flow in graded spheroids [T theorem 40]."""
    rows = []
    orders = QuadratureOrders(**{**vars(QuadratureOrders.fine()), "far": 4})
    for half, grading in ((0.1, 0.85), (0.03, 0.93), (0.01, 0.97)):
        for n_s, n_t in ((12, 6),) if quick else ((12, 6), (18, 8)):
            body = spheroid(n_s, n_t, c=half, grading=grading)
            rows.append(
                _traction_row(
                    "thin gap", body, lubrication(half), 0.0, orders, half=half, mesh=f"{n_s}x{n_t}"
                )
            )
    return rows


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
    surface = sample(body, body.coefficients, QuadratureOrders())
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
                used = _points(near.found[at], orders, layer)
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
    n = np.clip(np.ceil(offset - slope * np.log(found[:, 2:])), 4, 48)
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
            surface = sample(body, body.coefficients, QuadratureOrders())
            orders = QuadratureOrders()
            near = outer_pairs(surface, orders, slice(0, surface.outer.points.shape[0]))
            own = near.found[:, 2] < 0.0
            for layer in (Layer.SINGLE, Layer.DOUBLE):
                split = _points(near.found[~own], orders, layer)
                points = (~own).sum() * split + own.sum() * 4 * orders.radial * orders.angular
                moments = _best(
                    lambda s=surface, p=near, k=layer, o=orders: near_moments(
                        s, p, o, k, minus_plain=True
                    )
                )
                whole = moments
                if layer is Layer.SINGLE:
                    whole = _best(lambda s=surface, o=orders: near_field(s, o))
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


def _best(function: Callable[[], Any], repeats: int = 3) -> float:
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


ROWS: Sequence[Callable[[bool], list[Row]]] = (
    torus_rows,
    sphere_rows,
    order_rows,
    eigenvalue_rows,
    gap_rows,
    near_rows,
    speed_rows,
    gaps.run,
)
