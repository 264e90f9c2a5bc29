"""A run's folder: a new one for a scene, the scene of an old one, and what a run ends with."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from .. import loader
from ..output.atomic import RecordError
from ..output.step_records import StepResult
from ..output.vtk import inside
from ..scene_text import write
from ..sections import AnyScene

LOCK = "run.lock"  # who writes here; empty when nobody does


class FolderError(ValueError):
    """A run folder that cannot be used, with the remedy."""


class RunOutcome(Protocol):
    """How a run of any kind ended."""

    @property
    def result(self) -> StepResult: ...
    @property
    def step(self) -> int: ...
    @property
    def counts(self) -> Mapping[str, float]: ...
    @property
    def where(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def detail(self) -> str: ...


@dataclass(frozen=True)
class Finished:
    """How a run ended.

    Attributes
    ----------
    outcome : RunOutcome or None
        None if the user stopped it.
    picture : Path, optional
    saved : str
        What a stopped run can be continued from.
    """

    outcome: RunOutcome | None
    picture: Path | None = None
    saved: str = ""


def new_folder(scene: AnyScene, out: str | Path | None) -> Path:
    """Make the folder of a new run: ``out``, or the next free ``runs/<scene>-<n>``.

    Raises
    ------
    FolderError
        If it exists and is not empty, or if the scene's name is no name of a folder.
    OSError
        A place where no folder can be made.
    """
    if out is not None:
        folder = Path(out)
        if folder.is_file():
            raise FolderError(f"{folder} is a file; choose another --out")
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / LOCK).exists():  # else who writes there is asked first
            refuse_used(folder)
        return folder
    n = 1
    while True:
        folder = Path("runs") / f"{_file_name(scene.name)}-{n}"
        try:
            folder.mkdir(parents=True)  # by one process only, if two start at once
            return folder
        except FileExistsError:
            n += 1


def refuse_used(folder: Path) -> None:
    """Refuse a folder that holds something.

    Raises
    ------
    FolderError
        With what to do.
    """
    if any(entry.name != LOCK for entry in folder.iterdir()):
        raise FolderError(
            f"{folder} exists and is not empty; choose another --out, remove it, "
            f"or continue the run in it: airfold resume {folder}"
        )


def scene_of(folder: Path) -> AnyScene:
    """The scene of a run folder.

    Raises
    ------
    FolderError
        No run there.
    SceneError
        A run.toml that was edited into something wrong.
    """
    if not (folder / "run.toml").exists():
        raise FolderError(f"{folder} holds no run.toml; start a run there: airfold run SCENE --out")
    return loader.read(folder / "run.toml")


def refuse_cut(folder: Path, scene: AnyScene) -> None:
    """Refuse a run.toml that lacks keys: it was written with all of them.

    Raises
    ------
    FolderError
        With the first one.
    """
    found = _keys((folder / "run.toml").read_text(encoding="utf-8"))
    if lacking := [key for key in _keys(write(scene)) if key not in found]:
        raise FolderError(f"{folder}: run.toml lacks {lacking[0]}, it was cut; put it back")


def _keys(text: str) -> list[str]:
    """Paths of all keys of a scene file."""
    return [
        f"{name}.{key}"
        for name, part in tomllib.loads(text).items()
        for key in (part if isinstance(part, dict) else ("",))
    ]


def _file_name(name: str) -> str:
    try:
        if len(Path(inside(name)).parts) == 1 and not set(name) & set('/\\:*?"<>|'):
            return name
    except RecordError:
        pass
    raise FolderError(f"name: {name!r} is no name of a folder; change it, or give --out DIR")
