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
from .atomic import replacing
from .checkpoint import CheckpointError, read_arrays
from .history import History
from .run_record import RunRecord
from .vtk import FOLDER, read_frames, write_frames

if TYPE_CHECKING:
    from rich.console import Console

CHECKPOINT = "checkpoint.npz"


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
    CheckpointError
        A checkpoint of another scene, or an unreadable one.
    """

    def __init__(
        self, folder: Path, scene: AnyScene, console: Console, record: RunRecord, resume: bool
    ):
        self.folder, self.record, self._console = folder, record, console
        self._hash = _arithmetic(scene)
        self._began = time.perf_counter()
        self.start = self._load() if resume else {}
        self._history = History(folder / "history.csv")
        self._frames: list[tuple[float, str]] = []

    @property
    def elapsed(self) -> float:
        """Seconds since the start of this session."""
        return time.perf_counter() - self._began

    def cut_back(self, step: int, below: float) -> None:
        """Drop rows after ``step`` and frames from the time ``below`` on."""
        self._history.cut_back(step)
        frames = read_frames(self.folder / "fields.pvd")
        self._frames = [frame for frame in frames if frame[0] < below]

    def row(self, row: Mapping[str, float]) -> None:
        """Add a row to history.csv."""
        self._history.append(row)

    def frame(self, at: float, step: int, put: Callable[[Path], None]) -> None:
        """Add a field file at the "time" ``at``; ``put(path)`` writes it."""
        name = f"{FOLDER}/frame_{step:06d}.vtu"
        put(self.folder / name)
        self._frames.append((at, name))
        write_frames(self.folder / "fields.pvd", self._frames)

    def checkpoint(self, **arrays: np.ndarray | float) -> None:
        """Replace the checkpoint; ``arrays`` are the next session's `start`."""
        plain: dict[str, Any] = {name: np.asarray(value) for name, value in arrays.items()}
        with replacing(self.folder / CHECKPOINT, "wb") as file:
            np.savez(file, scene=np.array(self._hash), **plain)

    def news(self, text: str) -> None:
        """A line on the console."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def skip(self, what: str) -> None:
        """Note and tell what is left out."""
        self.record.skip(what)
        self.news(f"skipped: {what}")

    def _load(self) -> dict[str, np.ndarray]:
        path = self.folder / CHECKPOINT
        if not path.exists():
            return {}
        arrays = read_arrays(path)
        if str(arrays.pop("scene", "")) != self._hash:
            raise CheckpointError(
                f"{path.name} belongs to another scene than run.toml beside it; only name, "
                "description and output may be changed before a resume"
            )
        return arrays


def _arithmetic(scene: AnyScene) -> str:
    """Hash of all that enters the arithmetic."""
    bare = replace(cast(Any, scene), name="", description="", output=type(scene.output)())
    return hashlib.sha256(write(bare).encode()).hexdigest()
