"""Coupling schemes on the planar and the round pancake: contraction, assemblies, seconds, failures.

Contraction: rho a priori and as spectral radius of the assembled Gauss-Seidel map, against the
measured residual ratio of plain subiterations. Schemes: each from the same state over the same
steps; the error is the distance of the end configuration from the implicit one's, over the
displacement, next to the coupling tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from coupling.protocols import State, Structure
from coupling.time_loop import Simulation

from .. import build as space
from .. import loader
from ..config import SCHEMES
from ..planar import build as plane
from .pancake import FAST, History

Row = dict[str, Any]
DIVERGED = float("inf")
TESTED = tuple(s for s in SCHEMES if s != "constant")


def _simulation(name: str, options: Sequence[str]) -> tuple[Simulation, History, Any, Any]:
    scene = loader.read(name, list(options))
    builder = plane if scene.kind == "planar" else space
    history = History()
    return builder.simulation(scene, [history]), history, scene, builder


def states(name: str, options: Sequence[str], times: Sequence[float]) -> list[State]:
    """States of an implicit run at the first steps after the given times."""
    last = [f"time.end={max(times)}"] if max(times) > 0.0 else []
    sim, history, _, _ = _simulation(name, [*options, *last])
    if last:
        sim.run()
    found = history.states or [sim.initial]
    return [next((s for s in found if s.t >= t - 1e-9), found[-1]) for t in times]


def unloaded(sim: Simulation, state: State, dt: float) -> State:
    """The structure's own step: where the subiterations' structure solve is linearised."""
    step = sim.structure.step(state, None, dt, sim.structure.volume(state.coefficients))
    if not step.ok:
        raise ArithmeticError(f"unloaded structure step: {step.outcome.value}")
    return step.state


def measured_ratio(
    sim: Simulation, state: State, middle: State, dt: float, size: float = 1e-5
) -> float:
    """Growth of a small disturbance of ``middle`` over one true subiteration.

    Assembly on the disturbed shape, fluid solve and Newton. The disturbance is the worst mode,
    found by power iteration from a random start, so that the antisymmetric modes which a
    symmetric run hides are in it; its two signs are compared.
    """
    operator = sim.fluid.assemble(middle.coefficients)
    inverse = sim.structure.linearised(middle, dt)
    mode = np.random.default_rng(0).standard_normal(state.coefficients.size)
    for _ in range(60):
        traction = operator.traction((mode / dt).reshape(state.coefficients.shape))
        mode = inverse @ operator.load(traction).ravel()
        mode /= np.linalg.norm(mode)
    mode = mode.reshape(state.coefficients.shape)

    volume = sim.structure.volume(state.coefficients)

    def subiteration(x: np.ndarray) -> np.ndarray:
        disturbed = sim.fluid.assemble(x)
        load = disturbed.load(disturbed.traction((x - middle.coefficients) / dt))
        step = sim.structure.step(state, load, dt, volume, guess=middle.coefficients)
        return step.state.coefficients if step.ok else np.full_like(x, np.nan)

    still = middle.coefficients
    change = subiteration(still + size * mode) - subiteration(still - size * mode)
    return float(np.linalg.norm(change)) / (2.0 * size)


def contraction_row(name: str, options: Sequence[str], state: State, m: float, dt: float) -> Row:
    """rho three ways."""
    start = time.perf_counter()
    sim, _, scene, builder = _simulation(
        name, [*options, f"time.dt={dt}", f"time.end={dt}", f"fluid.mass_ratio={m}"]
    )
    middle = unloaded(sim, state, dt)
    radius = builder.measured_contraction(scene, middle)
    ratio = measured_ratio(sim, state, middle, dt)
    forecast = builder.contraction(scene, *([builder.bag(scene)] if builder is plane else []))
    return {
        "case": f"{name}, t = {state.t:g}: contraction",
        "seconds": time.perf_counter() - start,
        "error": abs(ratio / radius - 1.0),
        "reference": "spectral radius",
        "mass_ratio": m,
        "dt": dt,
        "spectral radius": radius,
        "residual ratio": ratio,
        "a priori": forecast,
        "a priori / radius": forecast / radius,
    }


def scheme_rows(
    name: str, options: Sequence[str], state: State, m: float, dt: float, steps: int
) -> list[Row]:
    """Every scheme over the same steps from one state."""
    rows, reference = [], None
    common = [*options, f"time.dt={dt}", f"time.end={state.t + steps * dt}"]
    common += [f"fluid.mass_ratio={m}", "time.closing=0"]
    for scheme in TESTED:
        sim, history, scene, _ = _simulation(name, [*common, f"coupling.scheme={scheme}"])
        sim = replace(sim, initial=state)
        began = time.process_time()
        outcome = sim.run(steps=steps)
        seconds = time.process_time() - began
        ended = outcome.t >= state.t + steps * dt - 1e-9
        c = history.states[-1].coefficients
        if reference is None:
            reference = c, sim.structure
        rows.append(
            {
                "case": f"{name}, t = {state.t:g}: {scheme}",
                "seconds": seconds / max(outcome.step, 1),
                "error": _distance(*reference, state, c) if ended else DIVERGED,
                "reference": "implicit",
                "tolerance": scene.coupling.tolerance,
                "mass_ratio": m,
                "dt": dt,
                "assemblies/step": outcome.counts["assemblies"] / max(outcome.step, 1),
                "rejected": outcome.counts["rejected"],
                "result": outcome.result.name.lower() if ended else f"only t = {outcome.t:g}",
            }
        )
    best = min((r["seconds"] for r in rows if np.isfinite(r["error"])
                and r["rejected"] == 0 and "semi" not in r["case"]), default=np.nan)  # fmt: skip
    return [{**row, "ratio": row["seconds"] / best, "peer": "fastest without rejection"}
            for row in rows]  # fmt: skip


def _distance(
    reference: np.ndarray, structure: Structure, start: State, coefficients: np.ndarray
) -> float:
    moved = structure.measure(reference - start.coefficients)
    return structure.measure(coefficients - reference) / max(moved, 1e-300)


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark; ``quick`` has one planar state and fewer mass ratios."""
    rows: list[Row] = []
    masses = (0.005, 0.1) if quick else (0.001, 0.005, 0.01, 0.1, 1.0, 5.0)
    steps_of = (0.06, 1.0, 8.0) if not quick else (1.0, 8.0)
    times = (0.0,) if quick else (0.0, 360.0, 1460.0)
    for state in states("planar-stokes-pancake", ["time.dt=4"], times):
        for dt in steps_of:
            rows.append(contraction_row("planar-stokes-pancake", [], state, 0.005, dt))
        for m in masses:
            for dt in steps_of:
                rows += scheme_rows("planar-stokes-pancake", [], state, m, dt, 3 if quick else 5)
    common = [o for o in FAST if "dt" not in o]
    state = states("pancake", [*common, "time.dt=8"], (0.0,))[0]
    for m in (0.005,) if quick else (0.005, 0.5):
        for dt in (1.0, 8.0):
            rows.append(contraction_row("pancake", common, state, m, dt))
            rows += scheme_rows("pancake", common, state, m, dt, 3)
    return rows
