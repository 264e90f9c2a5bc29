"""Runs and their folders: start one, resume it from its checkpoint, draw its pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .. import loader
from ..kinds.adaptive_flow import run as flow_run
from ..kinds.inflation.config import Scene
from ..kinds.inflation.picture import overview
from ..kinds.load_path import run as shell_run
from ..output.atomic import remove_parts, replacing
from ..output.checkpoint import CheckpointError, load, scene_hash
from .folder import Finished, FolderError
from .step_run import _run_stepwise
from .time_run import _run

if TYPE_CHECKING:
    from rich.console import Console



# Kinds without time: modules with Start, load, CheckpointError and run.
STEPWISE: Mapping[str, ModuleType] = {"model-adaptivity": flow_run, "shell": shell_run}


def start(
    scene: Scene,
    folder: Path,
    console: Console,
    *,
    tolerances: Mapping[str, Any] | None = None,
) -> Finished:
    """Run a scene from its beginning into an empty folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "run.toml") as file:
        file.write(loader.write(scene))
    if scene.kind in STEPWISE:
        return _run_stepwise(scene, folder, console, STEPWISE[scene.kind].Start())
    return _run(scene, folder, console, tolerances=tolerances)


def resume(
    folder: Path, console: Console, *, tolerances: Mapping[str, Any] | None = None
) -> Finished:
    """Continue the run of a folder from its checkpoint; records are cut back to it first.

    Raises
    ------
    FolderError
        No run there, or a checkpoint of another scene.
    loader.SceneError
        A run.toml that was edited into something wrong.
    """
    if not (folder / "run.toml").exists():
        raise FolderError(f"{folder} holds no run.toml; start a run there: airfold run SCENE --out")
    scene = loader.read(folder / "run.toml")
    if stepwise := STEPWISE.get(scene.kind):
        try:
            remove_parts(folder)
            return _run_stepwise(scene, folder, console, stepwise.load(folder, scene))
        except stepwise.CheckpointError as error:
            raise FolderError(f"{folder}: {error}") from error
    snapshot, file = None, folder / "checkpoint.npz"
    if file.exists():
        try:
            snapshot = load(file, scene_hash(scene))
        except CheckpointError as error:
            raise FolderError(f"{folder}: {error}") from error
    remove_parts(folder)
    return _run(scene, folder, console, snapshot, tolerances)


def _picture_of(folder: Path) -> Callable[[Path], Path]:
    """What draws the runs of the folder's kind."""
    kind = loader.read(folder / "run.toml").kind
    if kind == "model-adaptivity":
        from ..kinds.adaptive_flow.picture import overview as flow_overview

        return flow_overview
    if kind == "shell":
        from ..kinds.load_path.picture import overview as shell_overview

        return shell_overview
    if kind == "planar":
        from ..kinds.planar.picture import overview as planar_overview

        return planar_overview
    return overview


def _factory(scene: Scene) -> ModuleType:
    """What builds scenes of this kind for the one time loop."""
    if scene.kind == "planar":
        from ..kinds.planar import build
    elif scene.kind == "capsule":
        from ..kinds.capsule import build
    else:
        from ..kinds.inflation import build
    return build

