"""Coupling: contraction, schemes, rates, the capsule, and runs that ask for trouble.

Contraction: rho a priori and as spectral radius of the assembled Gauss-Seidel map, against the
measured residual ratio of plain subiterations. Schemes: each from the same state over the same
time; the error is the distance of the end configuration from the implicit one's, over the
displacement, next to the coupling tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from coupling import State, Structure
from coupling.schemes.contraction import film_symbol, worst_mode
from coupling.stepping.time_loop import Simulation

from ... import loader
from ...kinds.inflation import build as space
from ...kinds.planar import build as plane
from ...sections import SCHEMES
from ..inflation.pancake import FAST
from ..recorded import History
from . import capsule as coupling_capsule
from . import rates as coupling_rates
from . import stress as coupling_stress

Row = dict[str, Any]
DIVERGED = float("inf")
PLANE = "planar-stokes-pancake"
MATRIX_FREE = "implicit, matrix-free"
TESTED = tuple(s for s in SCHEMES if s != "constant")
COMMON = tuple(o for o in FAST if "dt" not in o)
MASSES, STEPS, TIMES = (0.001, 0.005, 0.1, 1.0, 5.0), (0.06, 1.0, 8.0), (0.0, 360.0, 1460.0)


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
    sim: Simulation,
    state: State,
    middle: State,
    dt: float,
    mode: np.ndarray,
    size: float = 1e-5,
) -> float:
    """Growth of a small disturbance ``mode`` of ``middle`` over one true subiteration.

    Assembly on the disturbed shape, fluid solve and Newton; its two signs are compared. The worst
    mode is antisymmetric where a symmetric run would hide it.
    """
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


def asymmetry(mode: np.ndarray) -> float:
    """Share of a planar mode that is antisymmetric: sheets move up on one side, down on the other.

    Positions are the even rows; the mirror image runs backwards, x changes sign.
    """
    x = mode.reshape(-1, 2)[::2]
    odd = 0.5 * (x - x[::-1] * np.array([-1.0, 1.0]))
    return float(np.linalg.norm(odd) / np.linalg.norm(x))


def planar_film(sim: Simulation, state: State, dt: float, radius: float) -> float:
    """S of the film between the upper sheet, from tip to tip, and what lies below it.

    Within a step that a membrane wave needs to run around a tip (a half circle at the start) the
    tips are stiff, and the film ends where they begin.
    """
    x = state.coefficients[::2]
    right, left = int(x[:, 0].argmax()), int(x[:, 0].argmin())
    upper = x[right : left + 1]
    lower = np.concatenate([x[left:], sim.fluid.boundary.inlet, x[: right + 1]])
    lower = lower[np.argsort(lower[:, 0])]
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(upper, axis=0), axis=1)))
    thickness = upper[:, 1] - np.interp(upper[:, 0], *lower.T)
    material = sim.structure.shell.material
    stiff = dt * np.sqrt(material.stiffness / material.density) > np.pi * radius
    tip = 0.5 * np.pi * radius if stiff else 0.0
    part = (thickness > 0.05 * np.median(thickness)) & (s >= tip) & (s <= s[-1] - tip)
    return film_symbol(s[part], thickness[part])


def contraction_row(name: str, options: Sequence[str], state: State, m: float, dt: float) -> Row:
    """rho three ways; in the plane the formula takes the film of the state itself."""
    start = time.process_time()
    options = [*options, f"time.dt={dt}", f"time.end={dt}", f"fluid.mass_ratio={m}"]
    options.append("coupling.reuse_tolerance=0")
    sim, _, scene, builder = _simulation(name, options)
    middle = unloaded(sim, state, dt)
    response = sim.fluid.assemble(middle.coefficients).response()
    inverse = sim.structure.linearised(middle, dt)
    radius, mode = worst_mode(response, inverse, dt, tolerance=1e-9)
    ratio = measured_ratio(sim, state, middle, dt, mode)
    if builder is plane:
        surface = 2.0 * np.pi / float(np.diff(plane.bag(scene).nodes).min())
        forecast = m * dt * max(surface, planar_film(sim, state, dt, scene.geometry.radius))
        more = {"antisymmetric": asymmetry(mode)}
    else:
        forecast = space.contraction(scene)
        soft, _, _, _ = _simulation(name, [*options, "structure.stiffness=1e-6"])
        inertia = soft.structure.linearised(middle, dt)
        more = {"radius, inertia alone": worst_mode(response, inertia, dt)[0]}
    return {
        "case": f"{name}, t = {state.t:g}: contraction",
        "seconds": time.process_time() - start,
        "error": abs(ratio / radius - 1.0),
        "reference": "spectral radius",
        "mass_ratio": m,
        "dt": dt,
        "spectral radius": radius,
        "residual ratio": ratio,
        "a priori": forecast,
        "a priori / radius": forecast / radius,
        **more,
    }


def scheme_rows(
    name: str,
    options: Sequence[str],
    state: State,
    m: float,
    dt: float,
    steps: int,
    schemes: Sequence[str] = TESTED,
) -> list[Row]:
    """Every scheme over the same time from one state.

    Seconds are CPU seconds over the number of steps of length dt. A scheme that needs steps
    below dt / 4, or more than half as many again, has failed.
    """
    rows, reference = [], None
    end = state.t + steps * dt
    common = [*options, f"time.dt={dt}", f"time.end={end}", f"time.dt_floor={dt / 4}"]
    common += [f"fluid.mass_ratio={m}", "time.closing=0", "coupling.reuse_tolerance=0"]
    for scheme in schemes:
        free = scheme == MATRIX_FREE
        chosen = ["coupling.scheme=implicit", "coupling.dense_limit=0"] if free else [
            f"coupling.scheme={scheme}"
        ]  # fmt: skip
        sim, history, scene, _ = _simulation(name, [*common, *chosen])
        # steps shorten by rejection only, so that the schemes solve the same equations
        sim = replace(sim, initial=state, control=replace(sim.control, busy=DIVERGED))
        began = time.process_time()
        outcome = sim.run(steps=steps + steps // 2)
        seconds = time.process_time() - began
        ended = outcome.t >= end - 1e-9
        c = history.states[-1].coefficients
        if reference is None:
            reference = c, sim.structure
        rows.append(
            {
                "case": f"{name}, t = {state.t:g}: {scheme}",
                "seconds": seconds / steps,
                "error": _distance(*reference, state, c) if ended else DIVERGED,
                "reference": "implicit",
                "tolerance": scene.coupling.tolerance,
                "mass_ratio": m,
                "dt": dt,
                "assemblies/step": outcome.counts["assemblies"] / max(outcome.step, 1),
                "steps": outcome.step,
                "rejected": outcome.counts["rejected"],
                "result": "completed" if ended else f"failed at {outcome.t:.5g}",
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


def kept_row(dt: float, steps: int) -> Row:
    """Assemblies that a slow run saves by keeping operators, and what it costs in accuracy."""
    ends = []
    for share in (0.0, 0.3):
        options = [
            *COMMON,
            f"time.dt={dt}",
            f"time.end={steps * dt}",
            f"coupling.reuse_tolerance={share}",
        ]
        sim, history, scene, _ = _simulation("pancake", options)
        began = time.process_time()
        counts = sim.run().counts
        ends.append((history.states, counts, time.process_time() - began))
    (whole, plain, reference), (states_kept, saved, seconds) = ends
    error = _distance(whole[-1].coefficients, sim.structure, whole[0], states_kept[-1].coefficients)
    return {
        "case": f"operators kept: pancake, dt = {dt:g}, {steps} steps",
        "seconds": seconds,
        "error": error,
        "reference": "all assembled",
        "tolerance": scene.fluid.tolerance,
        "assemblies": saved["assemblies"],
        "kept": saved["reused"],
        "of": plain["assemblies"],
        "ratio": seconds / reference,
        "peer": "all assembled",
    }


def _planar(quick: bool) -> list[Row]:
    rows: list[Row] = []
    masses, steps_of = ((0.005, 0.1), (1.0, 8.0)) if quick else (MASSES, STEPS)
    for state in states(PLANE, ["time.dt=4"], TIMES[:1] if quick else TIMES):
        for m in masses:
            rows += [contraction_row(PLANE, [], state, m, dt) for dt in steps_of]
        for m in masses:
            for dt in steps_of:
                rows += scheme_rows(PLANE, [], state, m, dt, 3 if quick else 6)
    return rows


def _round(quick: bool) -> list[Row]:
    """The round pancakes, at the asked mass ratios and steps, and at ten times and a tenth of m."""
    rows: list[Row] = []
    state = states("pancake", COMMON, (0.0,))[0]
    for m in (0.005,) if quick else (0.005, 0.5):
        for dt in (1.0, 8.0):
            rows.append(contraction_row("pancake", COMMON, state, m, dt))
            rows += scheme_rows("pancake", COMMON, state, m, dt, 3 if quick else 6)
    rows.append(kept_row(1.0, 10 if quick else 40))
    tested = ("implicit", MATRIX_FREE, "auto", "iqn-ils", "aitken")
    for name in () if quick else ("pancake", "pancake-20"):
        for start in states(name, [*COMMON, "time.dt=16"], (0.0, 160.0))[1:]:
            for m in (0.0005, 0.005, 0.05):
                rows += scheme_rows(name, COMMON, start, m, 8.0, 6, tested)
    return rows


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark; ``quick`` has one planar state and fewer of everything."""
    start = states(PLANE, [], (0.0,))[0]
    scheme_rows(PLANE, [], start, 0.005, 1.0, 1)  # compiles
    return [
        *_planar(quick),
        *_round(quick),
        *coupling_rates.rows(quick),
        *coupling_capsule.rows(quick),
        *coupling_stress.rows(quick),
    ]
