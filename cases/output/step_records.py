"""The records of a run without time: one row, frame, checkpoint and line of news a step."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from ..scene_text import write
from ..sections import AnyScene
from .atomic import RecordError
from .checkpoint import CHECKPOINT, read_arrays, write_arrays
from .history import History
from .run_record import RunRecord
from .seals import Seals, only_begun
from .vtk import FOLDER, LIST, write_frames

if TYPE_CHECKING:
    from rich.console import Console

FIRST = 2  # rows before the first checkpoint: the start and a first step


class StepResult(Protocol):
    """How a run ended; the value explains the member to a user."""

    @property
    def name(self) -> str: ...
    @property
    def value(self) -> str: ...
    @property
    def ok(self) -> bool: ...


@dataclass(frozen=True)
class StepOutcome:
    """How a run ended, and where."""

    result: StepResult
    step: int
    counts: Mapping[str, float]
    summary: str
    where: str
    detail: str = ""


class StepRecords:
    """Files and news of a run without time.

    Parameters
    ----------
    folder : Path
    scene : AnyScene
    console : rich.console.Console
    record : RunRecord
        run.json, for phases and skips.
    resume : bool
        Go on from the folder's checkpoint, if there is one.

    Attributes
    ----------
    start : mapping of arrays
        What the last checkpoint held; empty at the beginning.

    Raises
    ------
    RecordError
        A checkpoint of another scene, or a damaged folder.
    """

    def __init__(
        self, folder: Path, scene: AnyScene, console: Console, record: RunRecord, resume: bool
    ):
        self.folder, self.record, self._console = folder, record, console
        self._hash = _arithmetic(scene)
        self._began = time.perf_counter()
        self.start: dict[str, np.ndarray] = {}
        self._history = History(folder / "history.csv")
        self._seals = Seals(folder)
        if resume:
            self._load()

    @property
    def elapsed(self) -> float:
        """Seconds since the start of this session."""
        return time.perf_counter() - self._began

    def wanted(self, steps: str, ahead: int, **shapes: tuple[int, ...]) -> None:
        """Refuse a `start` that no run of this scene can have written.

        Parameters
        ----------
        steps : str
            Name of the array that counts steps.
        ahead : int
            How far it is ahead of the last row's step.
        **shapes : tuple of int
            Of the arrays by name, which must hold finite numbers.

        Raises
        ------
        RecordError
            With the name and what is wrong.
        """
        if not self.start:
            return
        for name, shape in {steps: (), **shapes}.items():
            array = self.start.get(name, np.array("missing"))
            number = array.dtype.kind in "biuf" and np.isfinite(array).all()
            if array.shape != shape or not number:
                raise RecordError(
                    f"{CHECKPOINT} cannot be continued from: {name} of shape {array.shape} and "
                    f"type {array.dtype}; finite numbers of shape {shape} are wanted"
                )
        if (row := self._seals.last_row()["step"]) != str(self.start[steps] - ahead):
            raise RecordError(
                f"{CHECKPOINT} cannot be continued from: {steps} = {self.start[steps]} after the "
                f"row of step {row} in history.csv"
            )

    def cut_back(self) -> None:
        """Drop the rows and frames that are to be taken again; the session begins."""
        self._seals.restore()
        self.record.write()

    def row(self, row: Mapping[str, float]) -> None:
        """Add a row to history.csv."""
        self._history.append(row)

    def frame(self, at: float, step: int, put: Callable[[Path], None]) -> None:
        """Add a field file at the "time" ``at``; ``put(path)`` writes it."""
        name = f"{FOLDER}/frame_{step:06d}.vtu"
        put(self.folder / name)
        self._seals.frames.append((at, name))
        write_frames(self.folder / LIST, self._seals.frames)

    def checkpoint(self, **arrays: np.ndarray | float) -> None:
        """Replace the checkpoint; ``arrays`` are the next session's `start`."""
        seals = self._seals.arrays(self._seals.mark())
        write_arrays(self.folder / CHECKPOINT, {**arrays, **seals}, self._hash)

    def news(self, text: str) -> None:
        """A line on the console."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def skip(self, what: str) -> None:
        """Note and tell what is left out."""
        self.record.skip(what)
        self.news(f"skipped: {what}")

    def _load(self) -> None:
        path = self.folder / CHECKPOINT
        if not path.exists():
            self.skip(only_begun(self.folder, FIRST))
            return
        self.start = read_arrays(path, self._hash, "name, description and output")
        self._seals = Seals(self.folder, self.start)
        for lost in self._seals.verify():
            self.skip(lost)


def _arithmetic(scene: AnyScene) -> str:
    """Hash of all that enters the arithmetic."""
    bare = replace(cast(Any, scene), name="", description="", output=type(scene.output)())
    return hashlib.sha256(write(bare).encode()).hexdigest()
