"""Start a run in its folder, or resume it from its checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..input_file import with_own_files
from ..kinds import KINDS
from ..kinds.kind import StepKind, TimeKind
from ..output.atomic import RecordError, replacing
from ..scene_text import write
from ..sections import AnyScene, TimedScene
from .folder import Finished, FolderError, refuse_cut, refuse_used, scene_of
from .lock import locked
from .step_run import run_steps
from .time_run import run_in_time

if TYPE_CHECKING:
    from rich.console import Console


def start(
    scene: AnyScene,
    folder: Path,
    console: Console,
    *,
    tolerances: Mapping[str, Any] | None = None,
) -> Finished:
    """Run a scene from its beginning into an empty folder.

    Raises
    ------
    FolderError
        Another process runs there, or the folder is not empty.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder):
        refuse_used(folder)
        scene = with_own_files(scene, folder)
        with replacing(folder / "run.toml") as file:
            file.write(write(scene))
        return _run(scene, folder, console, tolerances, resume=False)


def resume(
    folder: Path, console: Console, *, tolerances: Mapping[str, Any] | None = None
) -> Finished:
    """Continue the run of a folder from its checkpoint; records are cut back to it first.

    Checkpoint and records are verified before anything is changed.

    Raises
    ------
    FolderError
        No run there, another process writes there, a checkpoint of another scene, or a damaged
        file; the folder is as it was.
    SceneError
        A run.toml that was edited into something wrong.
    """
    scene_of(folder)
    with locked(folder):
        scene = scene_of(folder)
        refuse_cut(folder, scene)
        try:
            return _run(scene, folder, console, tolerances, resume=True)
        except RecordError as error:
            raise FolderError(f"{folder}: {error}") from error


def _run(
    scene: AnyScene,
    folder: Path,
    console: Console,
    tolerances: Mapping[str, Any] | None,
    *,
    resume: bool,
) -> Finished:
    from ._compile_kernels import kernels_ready

    kind = KINDS[scene.kind]
    with kernels_ready(scene, console):
        if isinstance(kind, TimeKind):
            scene = cast(TimedScene, scene)  # a scene of such a kind
            return run_in_time(kind, scene, folder, console, tolerances, resume=resume)
        assert isinstance(kind, StepKind)  # a kind is one or the other
        return run_steps(kind, scene, folder, console, tolerances, resume=resume)
