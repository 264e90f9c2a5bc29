"""Load paths and their folders: one row, frame and checkpoint a load step; resumable."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import BadZipFile

import numpy as np

from ...output.atomic import replacing
from ...output.history import History, read_history
from ...output.run_record import RunRecord
from ...output.vtk import FOLDER, read_frames, write_frames
from ...scene_text import write
from .config import Output, Scene
from .published import Reference, reference

if TYPE_CHECKING:
    from rich.console import Console

    from shells.equilibrium.load_paths import Path as LoadPath

    from .build import Problem

CHECKPOINT = "checkpoint.npz"


class Result(Enum):
    """How a load path ended."""

    COMPLETED = "the whole load is carried"
    NO_EQUILIBRIUM = "no equilibrium was found near the last one"

    @property
    def ok(self) -> bool:
        return self is Result.COMPLETED


@dataclass(frozen=True)
class Outcome:
    """How a load path ended, and where."""

    result: Result
    step: int
    fraction: float
    counts: Mapping[str, float]
    summary: str
    detail: str = ""

    @property
    def where(self) -> str:
        return f"step {self.step}, {self.fraction:.4g} of the load"


@dataclass(frozen=True)
class Start:
    """Where a path goes on: steps done, unknowns (None: unloaded), next increment of the load."""

    step: int = 0
    coefficients: np.ndarray | None = None
    increment: float | None = None
    newton: int = 0


class CheckpointError(ValueError):
    """A checkpoint of another scene, or an unreadable one."""


def load(folder: Path, scene: Scene) -> Start:
    """What to go on from; the beginning if there is no checkpoint.

    Raises
    ------
    CheckpointError
        It belongs to another scene or cannot be read.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        return Start()
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        start = Start(
            int(arrays["step"]),
            arrays["coefficients"],
            float(arrays["increment"]),
            int(arrays["newton"]),
        )
        same = str(arrays["scene"]) == _arithmetic(scene)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise CheckpointError(f"{path.name} is no readable checkpoint: {error}") from error
    if not same:
        raise CheckpointError(
            f"{path.name} belongs to another scene than run.toml beside it; only name, description "
            "and output may be changed before a resume"
        )
    return start


def _arithmetic(scene: Scene) -> str:
    """Hash of all that enters the arithmetic."""
    bare = Scene("", "", scene.geometry, scene.mesh, scene.structure, scene.load, Output())
    return hashlib.sha256(write(bare).encode()).hexdigest()


def run(scene: Scene, folder: Path, console: Console, record: RunRecord, start: Start) -> Outcome:
    """Run the load path into a folder."""
    record.write()
    known = reference(scene)
    if known is None:
        record.skip("deviation: no published or exact values for this scene")
    with record.phase("build"):
        from .build import problem

        posed = problem(scene)
    steps = _Steps(scene, folder, console, posed, known, start)
    with record.phase("run"):
        return steps.outcome(steps.follow())


class _Steps:
    """What is written at every load step."""

    def __init__(
        self,
        scene: Scene,
        folder: Path,
        console: Console,
        posed: Problem,
        known: Reference | None,
        start: Start,
    ):
        self.scene, self.folder, self.console = scene, folder, console
        self.posed, self.known, self.start = posed, known, start
        self.fractions = np.arange(1, scene.load.steps + 1) / scene.load.steps
        self.step, self.newton = start.step, start.newton
        self._began = time.perf_counter()
        self.history = History(folder / "history.csv")
        self.history.cut_back(start.step if start.coefficients is not None else -1)
        # half a step beyond the checkpoint: frames carry the load fraction as their time
        last = (start.step + 0.5) / scene.load.steps if start.coefficients is not None else -1.0
        self.frames = [frame for frame in read_frames(folder / "fields.pvd") if frame[0] < last]
        self.row: dict[str, float] = {}

    def follow(self) -> LoadPath | None:
        """The path from the start on; None if nothing is left of it."""
        c, fractions = self.start.coefficients, self.fractions[self.start.step :]
        if c is None:
            c = self.posed.start
            self._write(c, 0.0, 0, 0.0)
        if not fractions.size:
            return None
        return self.posed.follow(
            fractions,
            coefficients=c,
            start=self.start.step / self.scene.load.steps,
            increment=self.start.increment,
            accepted=self.accepted,
        )

    def accepted(self, path: LoadPath) -> None:
        """Row, frame, checkpoint and a line of news."""
        self.step += 1
        total = self.start.newton + path.newton_iterations
        new, self.newton = total - self.newton, total
        self._write(path.state.coefficients, path.parameter, new, path.steps[-1].residual)
        arrays = {
            "scene": np.array(_arithmetic(self.scene)),
            "step": np.array(self.step),
            "coefficients": path.state.coefficients,
            "increment": np.array(path.increment),
            "newton": np.array(total),
        }
        with replacing(self.folder / CHECKPOINT, "wb") as file:
            np.savez(file, **arrays)
        self.console.print(self._line(), markup=False, highlight=False, soft_wrap=True)

    def _write(self, c: np.ndarray, fraction: float, newton: int, residual: float) -> None:
        membrane, bending = self.posed.structure.shell.energy(c.ravel())
        row = {"step": self.step, "load": fraction}
        for name, moved in self.posed.displacement(c).items():
            row |= {f"{name}_{axis}": float(x) for axis, x in zip("xyz", moved, strict=True)}
        row |= {"membrane_energy": membrane, "bending_energy": bending}
        row |= {"newton_iterations": newton, "residual": residual}
        row["deviation"] = self.known.deviation(row) if self.known else math.nan
        row["wall_time"] = time.perf_counter() - self._began
        self.history.append(row)
        self.row = row
        every = self.scene.output.fields_every
        if every and (self.step % every == 0 or self.step == self.scene.load.steps):
            self._frame(c, fraction)

    def _frame(self, c: np.ndarray, fraction: float) -> None:
        from ...output.shell_fields import write_shell

        name = f"{FOLDER}/frame_{self.step:06d}.vtu"
        write_shell(
            self.folder / name,
            self.posed.structure.shell,
            c,
            tessellate=self.scene.output.tessellate,
        )
        self.frames.append((fraction, name))
        write_frames(self.folder / "fields.pvd", self.frames)

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

    def outcome(self, path: LoadPath | None) -> Outcome:
        """How it ended, with the largest deviation along the path."""
        failure = path.failure if path else ""
        fraction = path.parameter if path else 1.0
        newton = self.start.newton + (path.newton_iterations if path else 0)
        history = read_history(self.folder / "history.csv")
        seen = history["deviation"][np.isfinite(history["deviation"]) & (history["load"] > 0.0)]
        summary = f"{Result.COMPLETED.value}; {self._tips(history)}"
        if self.known and seen.size:
            summary += f"; at most {seen.max():.1e} from {self.known.source} at {seen.size} steps"
        result = Result.NO_EQUILIBRIUM if failure else Result.COMPLETED
        counts = {
            "steps": self.step,
            "newton_iterations": newton,
            "unknowns": self.posed.structure.E.shape[1],
        }
        return Outcome(result, self.step, fraction, counts, summary, failure)

    def _tips(self, history: Mapping[str, np.ndarray]) -> str:
        parts = []
        for name in self.posed.tracked:
            moved = ", ".join(f"{history[f'{name}_{axis}'][-1]:.4f}" for axis in "xyz")
            parts.append(f"{name} moved by ({moved})")
        return ", ".join(parts)
