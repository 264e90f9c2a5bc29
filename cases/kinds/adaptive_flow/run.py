"""Model-adaptive runs and their folders: one row, frame and checkpoint a step; resumable."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...output.atomic import replacing
from ...output.history import History
from ...output.run_record import RunRecord
from ...output.vtk import FOLDER, read_frames, write_frames, write_grid
from ...scene_text import write
from .config import Scene

if TYPE_CHECKING:
    from rich.console import Console

    from coupling.model_adaptivity.adaptive_loop import Result, Step

    from .build import Problem

CHECKPOINT = "checkpoint.npz"


@dataclass(frozen=True)
class Outcome:
    """How the loop ended."""

    result: Result
    step: int
    counts: Mapping[str, float]
    summary: str
    detail: str = ""

    @property
    def where(self) -> str:
        return f"step {self.step}"


@dataclass(frozen=True)
class Start:
    """Where a loop begins: its first step, flags, guess and the full model's goal."""

    first: int = 0
    flagged: np.ndarray | None = None
    x: np.ndarray | None = None
    reference: float | None = None


class CheckpointError(ValueError):
    """A checkpoint of another scene, or an unreadable one."""


def load(folder: Path, scene: Scene) -> Start:
    """What to go on from; the beginning if there is no checkpoint.

    Raises
    ------
    CheckpointError
        It belongs to another scene.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        return Start()
    with np.load(path, allow_pickle=False) as file:
        arrays = dict(file)
    if str(arrays["scene"]) != _arithmetic(scene):
        raise CheckpointError(
            f"{path.name} belongs to another scene than run.toml beside it; only name, description "
            "and output may be changed before a resume"
        )
    return Start(int(arrays["first"]), arrays["flagged"], arrays["x"], float(arrays["reference"]))


def _arithmetic(scene: Scene) -> str:
    """All that enters the arithmetic."""
    return write(Scene("", flow=scene.flow, goal=scene.goal, adaptivity=scene.adaptivity))


def run(scene: Scene, folder: Path, console: Console, record: RunRecord, start: Start) -> Outcome:
    """Run the loop into a folder."""
    began = time.perf_counter()

    def news(text: str) -> None:
        console.print(text, markup=False, highlight=False, soft_wrap=True)

    record.write()
    with record.phase("build"):
        from . import build

        for what in build.skipped(scene):
            record.skip(what)
            news(f"skipped: {what}")
        problem = build.problem(scene, news)
        reference = _reference(scene, problem, start, news)
    history = History(folder / "history.csv")
    history.cut_back(start.first - 1)
    frames = _kept_frames(folder, start.first)
    with record.phase("run"):
        for step in _steps(problem, reference, start):
            row = _row(step, problem, time.perf_counter() - began)
            history.append(row)
            if scene.output.fields_every and step.index % scene.output.fields_every == 0:
                frames.append((float(step.index), f"{FOLDER}/frame_{step.index:06d}.vtu"))
                write_grid(folder / frames[-1][1], build.grid(problem.flow, step))
                write_frames(folder / "fields.pvd", frames)
            news(_line(step))
            if step.result.name == "RUNNING":
                _save(folder / CHECKPOINT, scene, problem, step, reference)
    return _outcome(step, problem)


def _reference(scene: Scene, problem: Problem, start: Start, news: Any) -> float:
    from coupling.model_adaptivity.adaptive_loop import full_model

    if start.reference is not None:
        return start.reference
    if not scene.adaptivity.reference:
        return math.nan
    value, found = full_model(problem.flow, problem.goal)
    news(f"full model: goal {value:.6e}, {found.iterations} Newton iterations")
    return value


def _steps(problem: Problem, reference: float, start: Start) -> Iterator[Step]:
    from coupling.model_adaptivity.adaptive_loop import adapt

    return adapt(
        problem.flow,
        problem.goal,
        problem.strategy,
        reference=reference,
        flagged=start.flagged,
        start=start.x,
        first=start.first,
    )


def _kept_frames(folder: Path, first: int) -> list[tuple[float, str]]:
    return [(t, name) for t, name in read_frames(folder / "fields.pvd") if t < first]


def _save(path: Path, scene: Scene, problem: Problem, step: Step, reference: float) -> None:
    from coupling.model_adaptivity.adaptive_loop import enlarged

    arrays = {
        "scene": np.array(_arithmetic(scene)),
        "first": np.array(step.index + 1),
        "flagged": enlarged(problem.flow, step, problem.strategy),
        "x": step.solution.x,
        "reference": np.array(reference),
    }
    with replacing(path, "wb") as file:
        np.savez(file, **arrays)


def _row(step: Step, problem: Problem, wall: float) -> dict[str, float]:
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


def _outcome(step: Step, problem: Problem) -> Outcome:
    summary = (
        f"{step.result.value}; goal {step.goal:.6e}, bound {step.bound:.1e}, Navier-Stokes on "
        f"{step.element_fraction:.0%} of the elements"
    )
    counts = {"steps": step.index + 1, "unknowns": problem.flow.space.n}
    return Outcome(step.result, step.index, counts, summary)
