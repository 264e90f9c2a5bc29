"""A load path step by step: one row, frame and checkpoint each; resumable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from ...output.history import read_history
from ...output.step_records import StepOutcome, StepRecords
from .config import LoadPathScene
from .published import Reference, reference

if TYPE_CHECKING:
    from shells.equilibrium.load_paths import Path as LoadPath

    from .build import LoadPathProblem


class PathResult(Enum):
    """How a load path ended."""

    COMPLETED = "the whole load is carried"
    NO_EQUILIBRIUM = "no equilibrium was found near the last one"

    @property
    def ok(self) -> bool:
        """Whether the whole load is carried."""
        return self is PathResult.COMPLETED


def run(scene: LoadPathScene, records: StepRecords) -> StepOutcome:
    """Follow the path from where the records stand."""
    known = reference(scene)
    if known is None:
        records.record.skip("deviation: no published or exact values for this scene")
    with records.record.phase("build"):
        from .build import problem

        posed = problem(scene)
    steps = _Steps(scene, records, posed, known)
    with records.record.phase("run"):
        return steps.outcome(steps.follow())


class _Steps:
    """What is written at every load step."""

    def __init__(
        self,
        scene: LoadPathScene,
        records: StepRecords,
        posed: LoadPathProblem,
        known: Reference | None,
    ):
        self.scene, self.records, self.posed, self.known = scene, records, posed, known
        self.fractions = np.arange(1, scene.load.steps + 1) / scene.load.steps
        records.wanted("step", 0, coefficients=posed.start.shape, increment=(), newton=())
        start = records.start
        self.coefficients = start.get("coefficients")  # None: unloaded
        self.increment = float(start["increment"]) if start else None
        self.first, self.newton_before = (int(start.get(k, 0)) for k in ("step", "newton"))
        self.step, self.newton = self.first, self.newton_before
        records.cut_back()
        self.row: dict[str, float] = {}

    def follow(self) -> LoadPath | None:
        """The path from the start on; None if nothing is left of it."""
        c, fractions = self.coefficients, self.fractions[self.first :]
        if c is None:
            c = self.posed.start
            self._write(c, 0.0, 0, 0.0)
        if not fractions.size:
            return None
        return self.posed.follow(
            list(fractions),
            coefficients=c,
            start=self.first / self.scene.load.steps,
            increment=self.increment,
            accepted=self.accepted,
        )

    def accepted(self, path: LoadPath) -> None:
        """Row, frame, checkpoint and a line of news."""
        self.step += 1
        total = self.newton_before + path.newton_iterations
        new, self.newton = total - self.newton, total
        self._write(path.state.coefficients, path.parameter, new, path.steps[-1].residual)
        self.records.checkpoint(
            step=self.step,
            coefficients=path.state.coefficients,
            increment=path.increment,
            newton=total,
        )
        self.records.news(self._line())

    def _write(self, c: np.ndarray, fraction: float, newton: int, residual: float) -> None:
        membrane, bending = self.posed.shell.energy(c.ravel())
        row = {"step": self.step, "load": fraction}
        for name, moved in self.posed.displacement(c).items():
            row |= {f"{name}_{axis}": float(x) for axis, x in zip("xyz", moved, strict=True)}
        row |= {"membrane_energy": membrane, "bending_energy": bending}
        row |= {"newton_iterations": newton, "residual": residual}
        row["deviation"] = self.known.deviation(row) if self.known else math.nan
        row["wall_time"] = self.records.elapsed
        self.records.row(row)
        self.row = row
        every = self.scene.output.fields_every
        if every and (self.step % every == 0 or self.step == self.scene.load.steps):
            self._frame(c, fraction)

    def _frame(self, c: np.ndarray, fraction: float) -> None:
        from ...output.shell_fields import write_shell

        shell, cells = self.posed.shell, self.scene.output.tessellate
        self.records.frame(
            fraction, self.step, lambda path: write_shell(path, shell, c, tessellate=cells)
        )

    def _line(self) -> str:
        row = self.row
        moved = "  ".join(
            f"{name} {math.hypot(*(row[f'{name}_{axis}'] for axis in 'xyz')):.4f}"
            for name in self.posed.tracked
        )
        text = f"step {self.step:4d}  load {row['load']:.4f}  displacement {moved}"
        if math.isfinite(row["deviation"]):
            text += f"  deviation {row['deviation']:.1e}"
        return f"{text}  Newton {row['newton_iterations']}  {row['wall_time']:.1f} s"

    def outcome(self, path: LoadPath | None) -> StepOutcome:
        """How it ended, with the largest deviation along the path."""
        failure = path.failure if path else ""
        fraction = path.parameter if path else 1.0
        newton = self.newton_before + (path.newton_iterations if path else 0)
        history = read_history(self.records.folder / "history.csv")
        seen = history["deviation"][np.isfinite(history["deviation"]) & (history["load"] > 0.0)]
        summary = f"{PathResult.COMPLETED.value}; {self._tips(history)}"
        if self.known and seen.size:
            summary += f"; at most {seen.max():.1e} from {self.known.source} at {seen.size} steps"
        result = PathResult.NO_EQUILIBRIUM if failure else PathResult.COMPLETED
        counts = {
            "steps": self.step,
            "newton_iterations": newton,
            "unknowns": self.posed.structure.E.shape[1],
        }
        where = f"step {self.step}, {fraction:.4g} of the load"
        return StepOutcome(result, self.step, counts, summary, where, failure)

    def _tips(self, history: Mapping[str, np.ndarray]) -> str:
        parts = []
        for name in self.posed.tracked:
            moved = ", ".join(f"{history[f'{name}_{axis}'][-1]:.4f}" for axis in "xyz")
            parts.append(f"{name} moved by ({moved})")
        return ", ".join(parts)
