"""Full Galerkin operators of disc bags: storage, one application, one fluid solve.

Rows of `airfold bench compression`. Each bag has a process of its own, so that its peak of
memory is its own.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from hbem._threads_kernels import limited
from hbem.accuracy import budget
from hbem.layers.choice import Compression
from hbem.layers.compressed_layer import compressed_single_layer
from hbem.layers.direct_layer import DirectSingleLayer
from hbem.layers.layer import SingleLayer
from hbem.layers.single_layer import single_layer
from hbem.near.near_field import near_field
from hbem.solvers.saddle import IterativeSaddle, SaddleSolution, SaddleSystem
from hbem.solvers.schwarz import two_level_schwarz
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

from ...geometry.pillows.pillow import accordion, round_bag
from ..integrals.gaps import gap_traction, relative
from ..report import Row, best
from .measured import measured_rows

TRACTION = 1e-3  # error asked of the traction; `hbem.accuracy` turns it into matrix tolerances
STORED = {"aca": (1e-3, 1e-5, 1e-6), "h2": (1e-3, 1e-5, 1e-6)}
BODIES: dict[str, Callable[[int], Any]] = {
    "flat .05": lambda n: round_bag(n, gap=0.05),
    "fold n=2": lambda n: accordion(n, 2),
}
CHECKED = 20_000  # unknowns up to which a second flow is solved


def apart(function: Callable[..., Any], *arguments: Any) -> Any:
    """Rows from a fresh process whose kernels are loaded."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context, initializer=_warm) as pool:
        return pool.submit(function, *arguments).result()


def _warm() -> None:
    """Loads or compiles every kernel on a small bag."""
    bag = round_bag(8, gap=0.05)
    for compression in (Compression("h2", 1e-3), Compression("aca", 5e-5)):
        layer = single_layer(bag.surface, bag.coefficients, compression=compression)
        _, system, _ = fluid_solve(layer, manufactured(layer)[0])
        strain_error(layer, system)


def solve_row(n_s: int, gap: float, method: str, rules: bool = False) -> Row:
    """One fluid solve of a disc bag: assembly, preconditioner, GMRES to 1e-6.

    ``rules`` takes the quadrature that a run takes too; else the default orders.
    """
    bag = round_bag(n_s, gap=gap)
    asked = budget(TRACTION, bag.gap, bag.extent)
    compression = (
        Compression(method, asked.compression[method]) if method in asked.compression else None
    )
    orders = asked.orders if rules else QuadratureOrders()
    storage = "dense" if method == "dense" else "direct"
    began = time.perf_counter()
    layer = single_layer(
        bag.surface, bag.coefficients, orders, storage=storage, compression=compression
    )
    assembled = time.perf_counter() - began
    data, exact = manufactured(layer)
    solved, system, parts = fluid_solve(layer, data)
    row = {
        "case": f"solve, thinness {gap:g}, {method}" + (", rules of runs" if rules else ""),
        "seconds": assembled + parts["preconditioner"] + parts["gmres"],
        "error": relative(layer.surface, solved.solution, exact),
        "unknowns": layer.shape[0],
        "near": assembled,
        "reference": "manufactured traction, data by exact sums",
    }
    if compression is not None:
        s = layer.plain.statistics
        row |= {
            "tolerance": TRACTION,
            "matrix tolerance": compression.tolerance,
            "near": assembled - s.build_seconds,
            "build": s.build_seconds,
            "apply": s.apply_seconds,
            "error random": s.achieved,
        }
    row["peak GB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    row["kB/unknown"] = 1e-3 * stored_bytes(layer) / layer.shape[0]
    row |= parts
    if layer.shape[0] <= CHECKED:
        row["error of strain flow"] = strain_error(layer, system)
    return row


def stored_bytes(layer: SingleLayer) -> int:
    """Bytes of an operator, near field included."""
    far = 0
    if hasattr(layer, "plain"):
        s = layer.plain.statistics
        far = s.bytes_far + s.bytes_near
    elif hasattr(layer, "_matrix"):
        return layer.dense().nbytes
    return far + layer.near.nbytes


def storage_rows(body: str, n_s: int) -> list[Row]:
    """Operators on density functions: bytes an unknown, build, one application."""
    bag = BODIES[body](n_s)
    orders = QuadratureOrders()
    surface = sample(bag.surface, bag.coefficients, orders)
    near = near_field(surface, orders)
    found = []
    for method, tolerances in STORED.items():
        for tolerance in tolerances:
            layer = compressed_single_layer(surface, near, Compression(method, tolerance))
            s = layer.plain.statistics
            found.append(
                {
                    "case": f"operator {body}, {method}",
                    "seconds": s.build_seconds,
                    "error": s.achieved,
                    "unknowns": layer.shape[0],
                    "tolerance": tolerance,
                    "apply": s.apply_seconds,
                    "rank": s.rank_mean,
                    "kB/unknown": 1e-3 * stored_bytes(layer) / layer.shape[0],
                    "reference": "exact rows, random and constant densities",
                }
            )
            del layer
    return found


def apply_row(n_s: int) -> Row:
    """One far application on one thread: ACA at 1e-5 beside direct sums, and two threads."""
    bag = round_bag(n_s, gap=0.05)
    layer = single_layer(
        bag.surface, bag.coefficients, storage="direct", compression=Compression("aca", 1e-5)
    )
    exact = DirectSingleLayer(layer.surface, layer.near)
    x = np.random.default_rng(1).standard_normal((layer.shape[0] // 3, 3, 1))
    together = best(lambda: layer.plain.apply(x))
    with limited(1) as threads:
        alone, summed = best(lambda: layer.plain.apply(x)), best(lambda: exact.far(x), 1)
    return {
        "case": "far product, flat .05, aca",
        "seconds": alone,
        "error": layer.plain.statistics.achieved,
        "unknowns": layer.shape[0],
        "elements": bag.surface.n_elements,
        "tolerance": 1e-5,
        "peer": "direct sums",
        "peer_seconds": summed,
        "ratio": summed / alone,
        "threads": threads,
        "threads ratio": alone / together,
        "reference": "exact rows, random and constant densities",
    }


def manufactured(layer: SingleLayer) -> tuple[np.ndarray, np.ndarray]:
    """Data of a thin-gap traction [T thm 40] by exact sums, and its coefficients, ``(3 n,)``."""
    exact = gap_traction(layer.surface).ravel()
    return DirectSingleLayer(layer.surface, layer.near) @ exact, exact


def strain(layer: SingleLayer) -> np.ndarray:
    """Data of sheets that approach each other at a velocity linear in position."""
    return layer.surface.project(layer.surface.outer.points * [1.0, 1.0, -2.0]).ravel()


def fluid_solve(
    layer: SingleLayer, data: np.ndarray
) -> tuple[SaddleSolution, IterativeSaddle, dict[str, float]]:
    """Preconditioner and GMRES to a true residual of 1e-6."""
    surface = layer.surface
    began = time.perf_counter()
    schwarz = two_level_schwarz(SaddleSystem(layer, surface.constraint, surface.mass))
    middle = time.perf_counter()
    system = IterativeSaddle(
        layer, surface.constraint, surface.mass, tolerance=1e-6, preconditioner=lambda _: schwarz
    )
    solved = system.solve(data)
    parts = {
        "preconditioner": middle - began,
        "gmres": time.perf_counter() - middle,
        "iterations": solved.iterations,
        "residual": solved.residual,
    }
    return solved, system, parts


def strain_error(layer: SingleLayer, system: IterativeSaddle) -> float:
    """Traction error of a strain flow: a step of refinement by one exact residual.

    Without lubrication pressure the traction is small, and errors of the gap weigh more.
    """
    surface, data = layer.surface, strain(layer)
    solved = system.solve(data)
    exact = DirectSingleLayer(surface, layer.near)
    full = SaddleSystem(exact, surface.constraint, surface.mass)
    zeta = np.atleast_1d(solved.zeta) / full.scale
    residual = full.extend(data) - full.apply(np.concatenate([solved.solution, zeta]))
    correction = system.solve(residual[: full.n]).solution
    return relative(surface, solved.solution + correction, solved.solution)


def rows(quick: bool) -> Iterator[Row]:
    """All rows of this file; ``quick`` takes one small bag."""
    sizes = (44,) if quick else (44, 84)
    for gap in (0.05,) if quick else (0.05, 0.01):
        for n_s in sizes:
            for method in ("dense", "direct", "aca", "h2"):
                yield apart(solve_row, n_s, gap, method)
        if not quick:
            for method, rules in (("aca", False), ("h2", False), ("h2", True)):  # 5000 elements
                yield apart(solve_row, 102, gap, method, rules)
    if quick:
        yield from apart(measured_rows, 44, 0.05)
        return
    for gap in (0.05, 0.01):
        yield from apart(measured_rows, 102, gap)
    yield apart(solve_row, 260, 0.05, "h2")
    yield apart(apply_row, 142)
    for body in BODIES:
        first: dict[tuple[str, float], float] = {}  # bytes an unknown of the smaller bag
        for n_s in (84, 142):
            for row in apart(storage_rows, body, n_s):
                less = first.setdefault((row["case"], row["tolerance"]), row["kB/unknown"])
                yield row | {"growth": row["kB/unknown"] / less}
