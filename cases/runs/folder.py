"""A run's folder: a new one for a scene, the scene of an old one, and what a run ends with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from .. import loader
from ..output.step_records import StepResult
from ..sections import AnyScene


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
    """How a run ended: the outcome (None if the user stopped it) and its picture, if any."""

    outcome: RunOutcome | None
    picture: Path | None = None


def new_folder(scene: AnyScene, out: str | Path | None) -> Path:
    """The folder of a new run: ``out``, or the next free ``runs/<scene>-<n>``.

    Raises
    ------
    FolderError
        If it exists and is not empty.
    """
    if out is None:
        n = 1
        while (folder := Path("runs") / f"{scene.name}-{n}").exists():
            n += 1
    else:
        folder = Path(out)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FolderError(
                f"{folder} exists and is not empty; choose another --out, remove it, "
                f"or continue the run in it: airfold resume {folder}"
            )
    return folder


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
