"""Coupling schemes from the same state over the same time, and operators that are kept.

The error is the distance of the end configuration from the implicit one's, over the displacement.
Both take the same steps: a run that had one rejected steps on with smaller ones, whose time error
differs, and is compared with an implicit run that is refused the same steps.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from coupling import Result, Scheme, State, StepProblem, StepResult, Structure
from coupling.schemes.scheme import Memory

from ...kinds.schemes import LIMITS
from ...sections import SCHEMES
from ..pancake.suite import FAST
from ..report import Row
from .posed import pose

DIVERGED = float("inf")
MATRIX_FREE = "implicit, matrix-free"
TESTED = tuple(s for s in SCHEMES if s != "constant")
COMMON = tuple(o for o in FAST if "dt" not in o)


@dataclass(frozen=True)
class Refused(Scheme):
    """A scheme that fails at given steps, by their end and length, as another did there."""

    scheme: Scheme
    steps: frozenset[tuple[float, float]]

    def init(self) -> Memory:
        return self.scheme.init()

    def reset(self, memory: Memory) -> Memory:
        return self.scheme.reset(memory)

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        if (problem.state.t + problem.dt, problem.dt) in self.steps:
            return StepResult(Result.COUPLING)
        return self.scheme.attempt(problem, memory)


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
    rows: list[Row] = []
    references: dict[frozenset[tuple[float, float]], np.ndarray] = {}
    end = state.t + steps * dt
    common = [*options, f"time.dt={dt}", f"time.end={end}", f"time.dt_floor={dt / 4}"]
    common += [f"fluid.mass_ratio={m}", "time.closing=0", "coupling.reuse_tolerance=0"]
    for scheme in schemes:
        posed = pose(name, [*common, *_chosen(scheme)])
        began = time.process_time()
        outcome = posed.starting_from(state).run(steps=steps + steps // 2)
        seconds = time.process_time() - began
        ended = outcome.t >= end - 1e-9
        c = posed.history.states[-1].coefficients
        refused = frozenset((r.t, r.dt) for r in posed.history.rejections)
        if ended and refused not in references:
            implicit = [*common, *_chosen("implicit")]
            is_it = scheme == "implicit"
            references[refused] = c if is_it else _implicit(name, implicit, state, refused)
        rows.append(
            {
                "case": f"{name}, t = {state.t:g}: {scheme}",
                "seconds": seconds / steps,
                "error": _distance(references[refused], posed.structure, state, c)
                if ended
                else DIVERGED,
                "reference": "implicit" + (", the same steps refused" if refused else ""),
                # without iterations there is nothing that a tolerance could stop
                **(
                    {}
                    if "semi" in scheme
                    else {"coupling tolerance": posed.scene.coupling.tolerance}
                ),
                "mass_ratio": m,
                "dt": dt,
                "assemblies/step": outcome.counts["assemblies"] / max(outcome.step, 1),
                "steps": outcome.step,
                "rejected": outcome.counts["rejected"],
                "result": "completed" if ended else f"failed at {outcome.t:.5g}",
                # plain and relaxed subiterations are shown to fail; nothing else may
                **({"expected": "fail"} if not ended and scheme in LIMITS else {}),
            }
        )
    best = min((r["seconds"] for r in rows if np.isfinite(r["error"])
                and r["rejected"] == 0 and "semi" not in r["case"]), default=np.nan)  # fmt: skip
    return [{**row, "ratio": row["seconds"] / best, "peer": "fastest without rejection"}
            for row in rows]  # fmt: skip


def _implicit(
    name: str, options: Sequence[str], state: State, refused: frozenset[tuple[float, float]]
) -> np.ndarray:
    """End of an implicit run that is refused some steps."""
    posed = pose(name, options)
    start = posed.starting_from(state)
    replace(start, scheme=Refused(start.scheme, refused)).run()
    return posed.history.states[-1].coefficients


def _chosen(scheme: str) -> list[str]:
    if scheme == MATRIX_FREE:
        return ["coupling.scheme=implicit", "coupling.dense_limit=0"]
    return [f"coupling.scheme={scheme}"]


def _distance(
    reference: np.ndarray, structure: Structure, start: State, coefficients: np.ndarray
) -> float:
    moved = structure.measure(reference - start.coefficients)
    return structure.measure(coefficients - reference) / max(moved, 1e-300)


def kept_row(dt: float, steps: int) -> Row:
    """Assemblies that a slow run saves by keeping operators, and what it costs in accuracy."""
    runs = []
    for share in (0.0, 0.3):
        options = [
            *COMMON,
            f"time.dt={dt}",
            f"time.end={steps * dt}",
            f"coupling.reuse_tolerance={share}",
        ]
        posed = pose("pancake", options)
        began = time.process_time()
        counts = posed.simulation.run().counts
        runs.append((posed, counts, time.process_time() - began))
    (whole, plain, reference), (posed, saved, seconds) = runs
    states = whole.history.states
    kept = posed.history.states[-1].coefficients
    error = _distance(states[-1].coefficients, posed.structure, states[0], kept)
    return {
        "case": f"operators kept: pancake, dt = {dt:g}, {steps} steps",
        "seconds": seconds,
        "error": error,
        "reference": "all assembled",
        "assemblies": saved["assemblies"],
        "kept": saved["reused"],
        "of": plain["assemblies"],
        "ratio": seconds / reference,
        "peer": "all assembled",
    }
