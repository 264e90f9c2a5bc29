"""checkpoint.npz: everything a run needs to go on with the same arithmetic, replaced atomically.

Plain arrays without pickle: ``t, step, dt, coefficients, velocity, pressure``, then
``accumulated.<name>`` and ``memory.<name>``; kinds without time have arrays of their own. Beside
them ``format``, ``scene`` (a hash that guards against mixing runs), ``hash`` (of all the arrays)
and the `Seals` of the other files.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast
from zipfile import BadZipFile, ZipFile

import numpy as np

from ..input_file import input_files
from ..scene_text import write
from ..sections import Output, TimedScene
from .atomic import RecordError, replacing
from .recorder import Silent
from .seals import CHECKPOINT, Mark, Seals

if TYPE_CHECKING:
    from coupling import AcceptedStep, Outcome, Snapshot, State

FORMAT = 2
FREE = "time.end, name, description and output"  # keys that do not enter the arithmetic


class Checkpoint(Silent):
    """Recorder of checkpoint.npz; must hear of a step after the recorders whose files it seals.

    Attributes
    ----------
    saved : Snapshot or None
        What the file holds.
    """

    def __init__(self, folder: Path, scene: TimedScene, seals: Seals):
        self.path = folder / CHECKPOINT
        self.saved: Snapshot | None = None
        self._hash = scene_hash(scene)
        self._seals = seals
        self._marks: dict[int, Mark] = {}

    def mark(self, step: int) -> None:
        """Note how far the other files are at a step; the one before is kept.

        An interrupt may ask for a checkpoint of the step before the one being recorded.
        """
        before = {k: mark for k, mark in self._marks.items() if k == step - 1}
        self._marks = {**before, step: self._seals.mark()}

    def on_start(self, step: AcceptedStep) -> None:
        self.mark(step.step)

    def on_accepted(self, step: AcceptedStep) -> None:
        self.mark(step.step)

    def on_checkpoint(self, snapshot: Snapshot) -> None:
        save(self.path, snapshot, self._hash, self._seals.arrays(self._marks[snapshot.step]))
        self.saved = snapshot

    def close(self, outcome: Outcome) -> None:
        """Seal the last frame too, which is written at the end."""
        if self.saved is not None:
            self.mark(self.saved.step)
            self.on_checkpoint(self.saved)


def scene_hash(scene: TimedScene) -> str:
    """Hash of all that enters the arithmetic; a later end time and other output may differ."""
    output = Output(checkpoint_every=scene.output.checkpoint_every, seed=scene.output.seed)
    time = replace(scene.time, end=0.0)
    bare = replace(cast(Any, scene), name="", description="", output=output, time=time)
    inputs = [file.digest for *_, file in input_files(scene)]
    return hashlib.sha256("\n".join([write(bare), *inputs]).encode()).hexdigest()


def save(
    path: Path, snapshot: Snapshot, scene: str = "", seals: Mapping[str, Any] | None = None
) -> None:
    """Write a snapshot; the old file stays whole until the new one is complete."""
    arrays = {
        "step": snapshot.step,
        "dt": snapshot.dt,
        **asdict(snapshot.state),
        **{f"accumulated.{name}": value for name, value in snapshot.accumulated.items()},
        **{f"memory.{name}": value for name, value in snapshot.memory.items()},
    }
    write_arrays(path, {**arrays, **(seals or {})}, scene)


def load(path: Path, scene: str | None = None) -> Snapshot:
    """Read a snapshot back exactly.

    Raises
    ------
    RecordError
        A damaged file, or one written for another scene (its hash differs from ``scene``).
    """
    return snapshot_of(read_arrays(path, scene))


def write_arrays(path: Path, arrays: Mapping[str, Any], scene: str) -> None:
    """Replace a checkpoint by arrays and the hash of their scene.

    Raises
    ------
    TypeError
        Something that is no plain array.
    """
    plain = {name: np.asarray(value) for name, value in arrays.items()}
    if opaque := [name for name, value in plain.items() if value.dtype.hasobject]:
        raise TypeError(f"a checkpoint holds plain arrays, not {', '.join(opaque)}")
    plain |= {"format": np.asarray(FORMAT), "scene": np.asarray(scene)}
    with replacing(path, "wb") as file:
        np.savez(file, hash=np.asarray(_hash(plain)), **cast(Any, plain))


def read_arrays(path: Path, scene: str | None = None, free: str = FREE) -> dict[str, np.ndarray]:
    """Arrays of a checkpoint by name.

    Parameters
    ----------
    path : Path
    scene : str, optional
        Hash that the checkpoint's scene must have.
    free : str
        What of a scene may be changed before a resume, for the message.

    Raises
    ------
    RecordError
        A damaged file, one of another version, or one of another scene.
    """
    content = path.read_bytes()
    try:
        with ZipFile(BytesIO(content)) as archive:  # before numpy believes the sizes it reads
            if bad := archive.testzip():
                raise BadZipFile(f"{bad} is damaged")
        with np.load(BytesIO(content), allow_pickle=False) as file:
            arrays = dict(file)
        found = str(arrays.pop("hash"))
        if (version := int(arrays["format"])) != FORMAT:
            raise ValueError(f"it has format {version}, this version of airfold reads {FORMAT}")
        if found != _hash(arrays):
            raise ValueError("it was changed after it had been written")
    except Exception as error:  # a damaged archive can raise anything
        raise RecordError(f"{path.name} cannot be continued from: {_said(error)}") from error
    arrays.pop("format")
    if str(arrays.pop("scene")) != scene and scene is not None:
        raise RecordError(
            f"{path.name} belongs to another scene than run.toml beside it; only {free} may be "
            "changed before a resume"
        )
    return arrays


def snapshot_of(arrays: Mapping[str, np.ndarray]) -> Snapshot:
    """Snapshot of a checkpoint's arrays.

    Raises
    ------
    RecordError
        Arrays that are missing, or that no run can have written.
    """
    from coupling import Snapshot, State

    try:
        t, dt, pressure = (float(arrays[name]) for name in ("t", "dt", "pressure"))
        snapshot = Snapshot(
            step=int(arrays["step"]),
            dt=dt,
            state=State(t, arrays["coefficients"], arrays["velocity"], pressure),
            accumulated={k: float(v) for k, v in _group(arrays, "accumulated.").items()},
            memory=_group(arrays, "memory."),
        )
        wrong = list(_wrong(snapshot))
    except (ValueError, TypeError, KeyError) as error:
        wrong = [_said(error)]
    if wrong:
        raise RecordError(f"{CHECKPOINT} cannot be continued from: {'; '.join(wrong)}")
    return snapshot


def _wrong(snapshot: Snapshot) -> list[str]:
    """What no run can have written."""
    state, step, dt = snapshot.state, snapshot.step, snapshot.dt
    sums = snapshot.accumulated
    vectors = {"coefficients": state.coefficients, "velocity": state.velocity}
    arrays = {**vectors, **{f"memory.{name}": a for name, a in snapshot.memory.items()}}
    tests = [
        (step >= 0, f"step = {step}"),
        (0.0 < dt < math.inf, f"dt = {dt}"),
        (0.0 <= state.t < math.inf, f"t = {state.t}"),
        (math.isfinite(state.pressure), f"pressure = {state.pressure}"),
        *((math.isfinite(value), f"accumulated.{k} = {value}") for k, value in sums.items()),
        *((a.dtype.kind in "biuf", f"{k} holds {a.dtype}") for k, a in arrays.items()),
        *((a.dtype == float, f"{k} holds {a.dtype}") for k, a in vectors.items()),
    ]
    wrong = [text for good, text in tests if not good]
    if not wrong:
        wrong += [f"{k} is not finite" for k, a in arrays.items() if not np.isfinite(a).all()]
    if state.coefficients.ndim != 2 or state.coefficients.shape != state.velocity.shape:
        wrong.append(f"shapes {state.coefficients.shape} and {state.velocity.shape}")
    return wrong


def unlike(snapshot: Snapshot, initial: State, memory: Mapping[str, Any], end: float) -> list[str]:
    """Why a snapshot cannot be a state of the run that starts from ``initial``.

    Parameters
    ----------
    snapshot : Snapshot
    initial : State
    memory : mapping
        What the scheme carries at the beginning; it may carry more later.
    end : float
        Time at which the run is to end.
    """
    from coupling.stepping.history_row import SUMS

    lacking = {*SUMS, "energy_start"} - snapshot.accumulated.keys()
    lacking |= memory.keys() - snapshot.memory.keys()
    wrong = [f"{name} is missing" for name in sorted(lacking)]
    if (shape := snapshot.state.coefficients.shape) != initial.coefficients.shape:
        wrong.append(f"shape {shape}, the scene has {initial.coefficients.shape}")
    if snapshot.state.t > end * (1.0 + 1e-9):
        wrong.append(f"it is at t = {snapshot.state.t:g} already, beyond time.end = {end:g}")
    return wrong


def _hash(arrays: Mapping[str, np.ndarray]) -> str:
    found = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        found.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        found.update(array.tobytes())
    return found.hexdigest()


def _said(error: Exception) -> str:
    """An error's text on one line; the name of what is missing."""
    if isinstance(error, KeyError):
        return f"{error.args[0]} is missing"
    return " ".join(str(error).split()) or type(error).__name__


def _group(arrays: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {name[len(prefix) :]: v for name, v in arrays.items() if name.startswith(prefix)}
