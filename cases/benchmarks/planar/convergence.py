"""Space-time convergence of coupled planar runs, as [T figs. 4.3, 4.8]."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..report import Row
from .layers import rate
from .runs import PlanarRun, simulate


def space_time_distance(a: PlanarRun, b: PlanarRun, end: float, order: int = 2) -> float:
    """``|a - b|`` over ``|b|`` in L2(0, end; H^order), b on a mesh that contains a's nodes."""
    basis = b.structure.shell.basis
    local = np.searchsorted(a.structure.shell.basis.nodes, basis.nodes, side="right") - 1
    h = np.diff(a.structure.shell.basis.nodes)
    local = np.minimum(np.maximum(local, 0), h.size - 1)
    x = (basis.nodes - a.structure.shell.basis.nodes[local]) / h[local]
    embed = _embedding(local, x, h, 2 * h.size + 2)
    times = np.linspace(0.0, end, 33)[1:]
    total = norm = 0.0
    for t in times:
        ca, cb = (_state_at(run, t) for run in (a, b))
        total += _square(basis, embed @ ca - cb, order)
        norm += _square(basis, cb, order)
    return float(np.sqrt(total / norm))


def _embedding(e: np.ndarray, x: np.ndarray, h: np.ndarray, n: int) -> np.ndarray:
    """Hermite coefficients on a finer mesh: values and derivatives at its nodes."""
    matrix = np.zeros((2 * e.size, n))
    h = h[e]
    values = [1 - x**2 * (3 - 2 * x), h * x * (1 - x) ** 2, x**2 * (3 - 2 * x), h * x**2 * (x - 1)]
    slopes = [6 * x * (x - 1) / h, (1 - x) * (1 - 3 * x), 6 * x * (1 - x) / h, x * (3 * x - 2)]
    for k in range(4):
        matrix[2 * np.arange(e.size), 2 * e + k] += values[k]
        matrix[2 * np.arange(e.size) + 1, 2 * e + k] += slopes[k]
    return matrix


def _state_at(run: PlanarRun, t: float) -> np.ndarray:
    """Coefficients at time t, linear between steps."""
    times = run.history.column("t")
    k = int(np.clip(np.searchsorted(times, t), 1, times.size - 1))
    s = (t - times[k - 1]) / (times[k] - times[k - 1])
    before, after = run.states[k - 1].coefficients, run.states[k].coefficients
    return (1.0 - s) * before + s * after


def _square(basis: Any, coefficients: np.ndarray, order: int) -> float:
    jets = basis.jets(coefficients)
    parts = (jets.value, jets.tangent, jets.second)[: order + 1]
    square = sum((part**2).sum(axis=-1) for part in parts)
    return float((square * basis.dx).sum())


LEVELS = (0.75, 3.0, 12.0)  # times up to which errors are taken [T fig. 4.3]
PERIOD = 8.467  # (Lambda/pi)^2 of the pancake


def in_space(quick: bool) -> list[Row]:
    """Chapter 4 pancake in h; the reference is four times finer than the finest mesh."""
    levels = LEVELS[:2] if quick else LEVELS
    meshes = [24, 48] if quick else [24, 48, 96]
    common = ("time.dt=0.0661", f"time.end={levels[-1]}")
    runs = [
        (n, simulate("planar-potential-pancake", f"mesh.uniform={n}", *common))
        for n in [*meshes, 4 * meshes[-1]]
    ]
    return _ladder("potential pancake, L/{}", "4.3, h", runs, levels)


def in_time(quick: bool) -> list[Row]:
    """Chapter 4 pancake in dt; the reference is four times finer than the finest step."""
    levels = LEVELS[:1] if quick else LEVELS[:2]
    powers = [6, 7] if quick else [8, 9, 10, 11, 12, 13]
    runs = [
        (
            2**k,
            simulate(
                "planar-potential-pancake",
                "mesh.uniform=48",
                f"time.dt={PERIOD / 2**k}",
                f"time.end={levels[-1]}",
            ),
        )
        for k in [*powers, powers[-1] + 2]
    ]
    return _ladder("potential pancake, dt = period/{}", "4.3, dt", runs, levels)


def folded(quick: bool) -> list[Row]:
    """A folded bag with its contact force in h, elements halved between the joints [T fig. 4.8].

    Shorter panels than the scene's, for finer elements. Within a step bending smooths over
    ``(eps dt^2)^(1/4)``: 0.03 at the scene's rigidity, which these meshes do not resolve, and 0.08
    at the larger one, which they do.
    """
    rows = []
    for rigidity in (1e-2,) if quick else (1e-4, 1e-2):
        runs = []
        for k in (0, 1, 3) if quick else (0, 1, 2, 4):
            run = simulate(
                "planar-potential-fold",
                *("geometry.fold_radius=1", "geometry.panel=2", "geometry.chamber=4"),
                *("mesh.straight=1", "mesh.curved=0.53", f"mesh.halvings={k}"),
                *(f"structure.flexural_rigidity={rigidity}", "time.end=0.3"),
            )
            runs.append((run.structure.shell.basis.nodes.size - 1, run))
        case = f"potential fold, eps = {rigidity:g}, {{}} elements"
        rows += _ladder(case, f"4.8, eps = {rigidity:g}", runs, (0.15, 0.3))
    return rows


def _ladder(
    case: str, figure: str, runs: list[tuple[int, PlanarRun]], levels: tuple[float, ...]
) -> list[Row]:
    """One row a run but for the last, the reference: errors and rates up to each level.

    ``error`` is that of the last level in H2, ``position`` in L2.
    """
    names = [f"t <= {level:g}" for level in levels] + ["position"]
    count, reference = runs[-1]
    rows: list[Row] = []
    for n, run in runs[:-1]:
        errors = [space_time_distance(run, reference, t) for t in levels]
        errors.append(space_time_distance(run, reference, levels[-1], order=0))
        row: Row = {
            "case": case.format(n),
            "seconds": run.seconds,
            "error": errors[-2],
            "reference": f"{count}, {reference.seconds:.0f} s",
        }
        for k, name in enumerate(names):
            row[name] = errors[k]
            row[f"rate, {name}"] = (
                rate([2.0, 1.0], [rows[-1]["_errors"][k], errors[k]]) if rows else float("nan")
            )
        rows.append({**row, "_figure": figure, "_size": 1.0 / n, "_errors": errors})
    return rows
