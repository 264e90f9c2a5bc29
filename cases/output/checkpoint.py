"""checkpoint.npz: everything a run needs to go on with the same arithmetic, replaced atomically.

Plain arrays without pickle: ``t, step, dt, coefficients, velocity, pressure``, then
``accumulated.<name>`` and ``memory.<name>``. A hash of the scene guards against mixing runs.
"""

from __future__ import annotations

import hashlib
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast
from zipfile import BadZipFile

import numpy as np

from ..scene_text import write
from ..sections import Output, TimedScene
from .atomic import replacing
from .recorder import Silent

if TYPE_CHECKING:
    from coupling import Snapshot

FORMAT = 1


class CheckpointError(ValueError):
    """A checkpoint that cannot be continued from."""


class Checkpoint(Silent):
    """Recorder of checkpoint.npz."""

    def __init__(self, path: Path, scene: TimedScene):
        self.path = path
        self._hash = scene_hash(scene)

    def on_checkpoint(self, snapshot: Snapshot) -> None:
        save(self.path, snapshot, self._hash)


def scene_hash(scene: TimedScene) -> str:
    """Hash of all that enters the arithmetic; a later end time and other output may differ."""
    output = Output(checkpoint_every=scene.output.checkpoint_every, seed=scene.output.seed)
    time = replace(scene.time, end=0.0)
    bare = replace(cast(Any, scene), name="", description="", output=output, time=time)
    return hashlib.sha256(write(bare).encode()).hexdigest()


def save(path: Path, snapshot: Snapshot, scene: str = "") -> None:
    """Write a snapshot; the old file stays whole until the new one is complete."""
    arrays = {
        "format": FORMAT,
        "scene_hash": scene,
        "step": snapshot.step,
        "dt": snapshot.dt,
        **asdict(snapshot.state),
        **{f"accumulated.{name}": value for name, value in snapshot.accumulated.items()},
        **{f"memory.{name}": value for name, value in snapshot.memory.items()},
    }
    arrays = {name: np.asarray(value) for name, value in arrays.items()}
    if opaque := [name for name, value in arrays.items() if value.dtype.hasobject]:
        raise TypeError(f"a checkpoint holds plain arrays, not {', '.join(opaque)}")
    with replacing(path, "wb") as file:
        np.savez(file, **arrays)


def load(path: Path, scene: str | None = None) -> Snapshot:
    """Read a snapshot back exactly.

    Raises
    ------
    CheckpointError
        An unreadable file, or one written for another scene (its hash differs from ``scene``).
    """
    from coupling import Snapshot, State

    arrays = read_arrays(path)
    try:
        state = State(
            float(arrays["t"]),
            arrays["coefficients"],
            arrays["velocity"],
            float(arrays["pressure"]),
        )
        snapshot = Snapshot(
            step=int(arrays["step"]),
            dt=float(arrays["dt"]),
            state=state,
            accumulated={k: float(v) for k, v in _group(arrays, "accumulated.").items()},
            memory=_group(arrays, "memory."),
        )
        same = scene is None or str(arrays["scene_hash"]) == scene
    except (ValueError, KeyError) as error:
        raise CheckpointError(f"{path.name} is no readable checkpoint: {error}") from error
    if not same:
        raise CheckpointError(
            f"{path.name} belongs to another scene than run.toml beside it; only time.end, name, "
            "description and output may be changed before a resume"
        )
    return snapshot


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a checkpoint by name.

    Raises
    ------
    CheckpointError
        An unreadable file.
    """
    try:
        # opened here: numpy leaves a broken archive open
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            return dict(file)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise CheckpointError(f"{path.name} is no readable checkpoint: {error}") from error


def _group(arrays: dict[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {name[len(prefix) :]: v for name, v in arrays.items() if name.startswith(prefix)}
