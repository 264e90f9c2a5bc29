"""The adaptive loop step by step: one row, frame and checkpoint each; resumable."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from ...output.step_records import StepOutcome, StepRecords
from ...output.vtk import write_grid
from .config import AdaptiveFlowScene

if TYPE_CHECKING:
    from coupling.model_adaptivity.adaptive_loop import Step

    from .build import AdaptiveProblem


def run(scene: AdaptiveFlowScene, records: StepRecords) -> StepOutcome:
    """Run the loop from where the records stand."""
    with records.record.phase("build"):
        from . import build

        for what in build.skipped(scene):
            records.skip(what)
        problem = build.problem(scene, records.news)
        space = problem.flow.space
        records.wanted("first", 1, flagged=(space.n_elements,), x=(space.n,))
        reference = _reference(scene, problem, records)
    first = int(records.start.get("first", 0))
    records.cut_back()
    every = scene.output.fields_every
    with records.record.phase("run"):
        for step in _steps(problem, reference, records, first):
            records.row(_row(step, problem, records.elapsed))
            if every and step.index % every == 0:
                grid = build.grid(problem.flow, step)
                records.frame(float(step.index), step.index, partial(write_grid, grid=grid))
            records.news(_line(step))
            if step.result.name == "RUNNING":
                _save(records, problem, step, reference)
    return _outcome(step, problem)


def _reference(scene: AdaptiveFlowScene, problem: AdaptiveProblem, records: StepRecords) -> float:
    from coupling.model_adaptivity.adaptive_loop import full_model

    if "reference" in records.start:
        return float(records.start["reference"])
    if not scene.adaptivity.reference:
        return math.nan
    value, found = full_model(problem.flow, problem.goal)
    records.news(f"full model: goal {value:.6e}, {found.iterations} Newton iterations")
    return value


def _steps(
    problem: AdaptiveProblem, reference: float, records: StepRecords, first: int
) -> Iterator[Step]:
    from coupling.model_adaptivity.adaptive_loop import adapt

    return adapt(
        problem.flow,
        problem.goal,
        problem.strategy,
        reference=reference,
        flagged=records.start.get("flagged"),
        start=records.start.get("x"),
        first=first,
    )


def _save(records: StepRecords, problem: AdaptiveProblem, step: Step, reference: float) -> None:
    from coupling.model_adaptivity.adaptive_loop import enlarge

    records.checkpoint(
        first=step.index + 1,
        flagged=enlarge(problem.flow, step, problem.strategy),
        x=step.solution.x,
        reference=reference,
    )


def _row(step: Step, problem: AdaptiveProblem, wall: float) -> dict[str, float]:
    return {
        "step": step.index,
        "element_fraction": step.element_fraction,
        "volume_fraction": step.volume_fraction,
        "goal": step.goal,
        "estimate": step.estimate,
        "thesis_eps": step.thesis_eps,
        "bound": step.bound,
        "error": step.error,
        "error_rel_J0": step.error_rel_j0,
        "effectivity": step.effectivity,
        "algebraic": step.algebraic,
        "discretisation": problem.discretisation / step.goal,
        "converged": int(step.solution.ok),
        "newton_iterations": step.solution.iterations,
        "factorisations": step.solution.factorisations,
        "linear_residual": step.solution.linear_residual,
        "wall_time": wall,
    }


def _line(step: Step) -> str:
    text = f"step {step.index:3d}  Navier-Stokes {step.element_fraction:6.1%} of the elements"
    if not step.solution.ok:
        return f"{text}  NOT CONVERGED: {step.solution.outcome.value}"
    text += f"  estimate {step.estimate: .3e}  bound {step.bound:.2e}"
    if math.isfinite(step.error_rel_j0):
        text += f"  error {step.error_rel_j0: .3e}"
    return f"{text}  Newton {step.solution.iterations}  {sum(step.seconds.values()):.1f} s"


def _outcome(step: Step, problem: AdaptiveProblem) -> StepOutcome:
    summary = (
        f"{step.result.value}; goal {step.goal:.6e}, bound {step.bound:.1e}, Navier-Stokes on "
        f"{step.element_fraction:.0%} of the elements"
    )
    counts = {"steps": step.index + 1, "unknowns": problem.flow.space.n}
    return StepOutcome(step.result, step.index, counts, summary, f"step {step.index}")
