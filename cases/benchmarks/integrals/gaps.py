"""Thin gaps: squeeze film, preconditioners against thinness and size, collapsed corners, rules.

Rows of `airfold bench integrals`. Errors are relative to what `reference` names.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.sparse.linalg import spsolve

from hbem.accuracy import RULES
from hbem.flows.stokes_flow import StokesFlow
from hbem.layers.layer import SingleLayer
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import DenseSaddle, IterativeSaddle, MassPreconditioner, SaddleSystem
from hbem.solvers.schwarz import two_level_schwarz
from hbem.surfaces.patches import BezierPatches, union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import SampledSurface

from ...geometry.bodies import closed_body
from ...geometry.pillows.pillow import PillowBag, accordion, round_bag
from ..report import Row

RESIDUAL = 1e-6  # asked of GMRES
RIM = 0.05  # radius of a disc's rounded rim
FINEST = QuadratureOrders(
    far=6, near_ball=2.0, near_offset=14.0, near_slope=4.3, radial=24, angular=24
)
BAGS: dict[str, Callable[[int], PillowBag]] = {
    "flat .05": lambda n: round_bag(n, gap=0.05),
    "flat .01": lambda n: round_bag(n, gap=0.01),
    "fold n=2": lambda n: accordion(n, 2),
    "fold n=4": lambda n: accordion(n, 4),
}


def run(quick: bool) -> list[Row]:
    """All rows of this file."""
    return [*squeeze_rows(quick), *preconditioner_rows(quick), *corner_rows(), *rule_rows(quick)]


# --- squeeze film -------------------------------------------------------------------------------


def disc(n_s: int, n_t: int, height: float, *, degree: int = 3, rim: int = 6) -> BezierPatches:
    """A disc of radius 1 with a half-circle rim, its middle at ``height``.

    Elements shrink towards the rim: ``rho = w (1 - RIM)``, ``w = x + 0.8 x (1 - x)``.
    """
    flat = (n_s - rim) // 2

    def shape(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        u = n_s * s
        angle = np.pi * np.clip((u - flat) / rim, 0.0, 1.0)
        x = np.clip(np.minimum(u, n_s - u) / flat, 0.0, 1.0)
        rho = (1.0 - RIM) * (x + 0.8 * x * (1.0 - x)) + RIM * np.sin(angle)
        z = height + RIM * np.cos(angle)
        return np.stack([rho * np.cos(2 * np.pi * t), rho * np.sin(2 * np.pi * t), z], axis=-1)

    return closed_body(shape, n_s, n_t, degree=degree)


def reynolds_force(h: float) -> float:
    """Lubrication force of two such discs at unit closing speed: ``6 pi int rho^3 / h(rho)^3``."""
    rho = np.linspace(0.0, 1.0, 200001)
    inward = np.maximum(rho - 1.0 + RIM, 0.0)
    gap = h + 2.0 * (RIM - np.sqrt(np.maximum(RIM**2 - inward**2, 0.0)))
    return float(6.0 * np.pi * np.trapezoid(rho**3 / gap**3, rho))


def squeeze_rows(quick: bool) -> Iterator[Row]:
    """Two discs approach each other; the force tends to ``3 pi mu a^4 V / (2 h^3)``.

    At finite gaps: rounded rims shorten the film (Reynolds' equation on the true gap) and the flow
    outside the film adds O(h / a).
    """
    coarse, finer = (14, 8 if quick else 10), ((20, 12), (26, 14))
    meshes = [(h, *coarse) for h in ((0.1, 0.03) if quick else (0.3, 0.1, 0.03, 0.01))]
    for h, n_s, n_t in meshes if quick else [*meshes, *((0.01, *m) for m in finer)]:
        start = time.perf_counter()
        upper = disc(n_s, n_t, 0.5 * h + RIM)
        lower = disc(n_s, n_t, -0.5 * h - RIM)
        flow = StokesFlow(union(upper, lower), orders=replace(RULES[-1][0], radial=14, angular=16))
        falls = np.where(flow.points[:, 2:] > 0.0, [[0.0, 0.0, -0.5]], [[0.0, 0.0, 0.5]])
        found = flow.traction(falls)
        force = float(np.abs(found.force()[:, 2]).mean())
        film, flat = reynolds_force(h), 1.5 * np.pi / h**3
        yield {
            "case": "squeeze film",
            "h/a": h,
            "mesh": f"{n_s}x{n_t}",
            "unknowns": 3 * flow.patches.n_dofs,
            "force / film": force / film,
            "force / flat": force / flat,
            "zeta": float(np.abs(found.zeta).max()),
            "error": abs(force / film - 1.0),
            "seconds": time.perf_counter() - start,
            "reference": "Reynolds film, exact as h/a tends to 0",
        }


# --- preconditioners ----------------------------------------------------------------------------


def gap_traction(surface: SampledSurface) -> np.ndarray:
    """Coefficients of the thin-gap polynomial's traction [T thm 40], ``(n_dofs, 3)``."""
    x, normals = surface.outer.points, surface.outer.normals
    h, (a, b, c) = np.abs(x[:, 2]).max(), x.T
    gradient = np.zeros((x.shape[0], 3, 3))
    gradient[:, 0, 0] = gradient[:, 1, 1] = h * h - c * c
    gradient[:, 0, 2], gradient[:, 1, 2] = -2 * a * c, -2 * b * c
    gradient[:, 2, 2] = 2 * c * c - 2 * h * h
    stress = gradient + np.swapaxes(gradient, 1, 2)
    stress -= (2 * c * c - a * a - b * b)[:, None, None] * np.eye(3)
    tau = np.einsum("pik,pk->pi", stress, normals)
    mean = surface.outer.weights @ np.sum(tau * normals, axis=1) / surface.outer.weights.sum()
    mass, c = surface.mass.tocsc(), surface.constraint
    found, normal = spsolve(mass, surface.project(tau - mean * normals)), spsolve(mass, c)
    # exactly free of net pressure in the discrete sense too, as every solution is
    return found - normal * (np.sum(c * found) / np.sum(c * normal))


def relative(surface: SampledSurface, found: np.ndarray, exact: np.ndarray) -> float:
    """Relative L2 difference of two densities."""

    def size(v: np.ndarray) -> float:
        v = v.reshape(-1, 3)
        return float(np.sqrt(np.sum(v * (surface.mass @ v))))

    return size(found - exact) / size(exact)


def preconditioner_rows(quick: bool) -> Iterator[Row]:
    """GMRES iterations to a true residual of 1e-6, with the preconditioner's build time."""
    sizes = (28,) if quick else (44, 84)
    for name, make in BAGS.items():
        for n in sizes:
            if n == 28 and name.startswith("fold"):
                continue
            yield from _solves(name, make(n))


def _solves(name: str, bag: PillowBag) -> Iterator[Row]:
    orders = QuadratureOrders() if name == "flat .05" else QuadratureOrders.fine()
    start = time.perf_counter()
    layer = single_layer(bag.patches(), bag.coefficients, orders, storage="dense")
    assembly = time.perf_counter() - start
    surface = layer.surface
    exact = gap_traction(surface).ravel()
    data = layer @ exact
    for kind, build in (("schwarz", two_level_schwarz), ("mass", MassPreconditioner)):
        if kind == "mass" and layer.shape[0] > 3000:
            continue  # hundreds of iterations, as the smaller ones show
        yield _solve(name, layer, data, exact, kind, build, assembly)


def _solve(
    name: str,
    layer: SingleLayer,
    data: np.ndarray,
    exact: np.ndarray,
    kind: str,
    build: Callable,
    assembly: float,
) -> Row:
    surface = layer.surface
    start = time.perf_counter()
    made = build(SaddleSystem(layer, surface.constraint, surface.mass))
    parts = getattr(made, "seconds", {"subdomains": 0.0, "coarse": 0.0})
    built = time.perf_counter()
    most = 400 if layer.shape[0] > 1200 else 100  # --quick: the mass matrix fails in thin gaps
    found = IterativeSaddle(
        layer, surface.constraint, surface.mass, RESIDUAL, most, preconditioner=lambda system: made
    ).solve(data)
    # the mass matrix is shown because it fails in thin gaps; nothing else may
    failed = {"expected": "fail"} if kind == "mass" and found.residual > RESIDUAL else {}
    return {
        "case": f"gmres {kind} {name}",
        "unknowns": layer.shape[0],
        "iterations": found.iterations,
        "residual": found.residual,
        "assembly": assembly,
        "subdomains": parts["subdomains"],
        "coarse": parts["coarse"],
        "gmres": time.perf_counter() - built,
        "seconds": time.perf_counter() - start,
        "residual tolerance": RESIDUAL,
        "error": relative(surface, found.solution, exact),
        "reference": "manufactured traction, same matrix",
        **failed,
    }


# --- collapsed corners and rules ----------------------------------------------------------------


@cache
def _reference(
    kind: str, eps: float, n: int
) -> tuple[BezierPatches, np.ndarray, np.ndarray, np.ndarray]:
    """A disc bag: patches, configuration, manufactured traction and its data by the finest rule."""
    bag = round_bag(n, gap=eps, flatten=0.0 if kind == "ellipsoid" else 3.0)
    layer = single_layer(bag.patches(), bag.coefficients, FINEST, storage="dense")
    exact = gap_traction(layer.surface).ravel()
    return bag.patches(), bag.coefficients, exact, layer @ exact


def _rule_row(case: str, kind: str, eps: float, n: int, orders: QuadratureOrders) -> Row:
    patches, coefficients, exact, data = _reference(kind, eps, n)
    start = time.perf_counter()
    layer = single_layer(patches, coefficients, orders, storage="dense")
    seconds = time.perf_counter() - start
    surface = layer.surface
    found = DenseSaddle(layer, surface.constraint, surface.mass).solve(data)
    return {
        "case": case,
        "body": kind,
        "thinness": eps,
        "elements": patches.n_elements,
        "near": f"{orders.near_offset:g}/{orders.near_slope:g}",
        "polar": f"{orders.radial}x{orders.angular}",
        "far": orders.source,
        "pairs": layer.n_near,
        "seconds": seconds,
        "error": relative(surface, found.solution, exact),
        "reference": "far 6, near 14/4.3, polar 24x24",
    }


def corner_rows() -> Iterator[Row]:
    """A body with four collapsed corners at thinness 0.01: refining the rules converges."""
    steps = ((4, 5.0, 2.8, 8), (4, 8.0, 3.6, 14), (5, 10.0, 3.8, 18), (6, 12.0, 4.0, 22))
    for far, near, slope, radial in steps:
        orders = QuadratureOrders(
            far=far, near_offset=near, near_slope=slope, radial=radial, angular=radial + 2
        )
        yield _rule_row("collapsed corners", "flat", 0.01, 28, orders)


def rule_rows(quick: bool) -> Iterator[Row]:
    """The table behind `hbem.accuracy`: traction error of each rule against thinness."""
    thin = (0.05,) if quick else (0.3, 0.1, 0.05, 0.02, 0.01)
    for kind in ("flat",) if quick else ("flat", "ellipsoid"):
        for eps in thin:
            for orders, _ in RULES:
                yield _rule_row("rule", kind, eps, 28, orders)
