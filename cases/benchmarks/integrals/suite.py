"""Accuracy and speed of the boundary integrals: exact flows, near-singular rules, assembly.

``ROWS`` lists the row functions; each takes ``quick`` and returns rows. Errors of tractions are
relative in L2 against exact solutions; ``best`` is the best approximation in the same space.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from hbem.flows.formulation import jump_data, needs_double_layer
from hbem.layers.double_layer import double_layer
from hbem.layers.point_sums import single_layer_sums
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import DenseSaddle
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import SampledSurface, sample

from ...geometry.bodies import fitted, sphere, spheroid, torus
from ..report import Row
from . import gaps, near_rules
from .near_rules import coefficients_of

Flow = tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray, np.ndarray], np.ndarray]]
STRAIN = np.array([[1.0, 0.5, 0.0], [0.5, -2.0, 0.3], [0.0, 0.3, 1.0]])
AXIS = np.array([0.0, 0.0, 1.0])
DISTANCES = (1e-1, 1e-2, 1e-3, 1e-4)
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def run(quick: bool) -> Iterator[Row]:
    """All rows, as they come; ``quick`` leaves out the larger meshes."""
    return (row for rows in ROWS for row in rows(quick))


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
    layer = single_layer(body, coefficients_of(body), orders, storage="dense")
    surface = layer.surface
    data = surface.project(flow[0](surface.outer.points))
    double, projected = None, None
    if needs_double_layer(ratio):
        double = double_layer(surface, orders)
        projected = splu(surface.mass.tocsc()).solve(data).ravel()
    rhs = jump_data(data.ravel(), ratio, double, projected)
    solved = DenseSaddle(layer, surface.constraint, surface.mass).solve(rhs)
    seconds = time.perf_counter() - start
    fine = sample(body, coefficients_of(body), QuadratureOrders(outer=norm))
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
                # 3 outer points are the floor of cubic tractions: the table of orders shows it
                row = _traction_row(
                    "torus shear", body, (shear, shear_traction), 0.0,
                    QuadratureOrders(outer=degree + 1), degree=degree, geometry=geometry, n=n,
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
        layer = single_layer(body, coefficients_of(body), storage="dense")
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


ROWS: Sequence[Callable[[bool], list[Row]]] = (
    torus_rows,
    sphere_rows,
    order_rows,
    eigenvalue_rows,
    gap_rows,
    near_rules.run,
    gaps.run,
)
