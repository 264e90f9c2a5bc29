"""The pictures of a run folder, made from its files alone."""

from __future__ import annotations

from pathlib import Path

from ..kinds import KINDS
from ..output.figures import NoPicture
from ..output.run_record import RunRecord
from ..sections import AnyScene
from .folder import FolderError, scene_of


def draw(folder: Path) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    _check(folder)
    scene = scene_of(folder)
    try:
        return KINDS[scene.kind].draw(folder, scene)
    except NoPicture as error:
        raise FolderError(str(error)) from error


def animate(folder: Path) -> Path:
    """Draw animation.gif of a run folder.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    _check(folder)
    try:
        return KINDS[scene_of(folder).kind].animate(folder)
    except NoPicture as error:
        raise FolderError(str(error)) from error


def compare(folder: Path, other: Path) -> Path:
    """Draw beside.png in ``folder``: cuts of both runs at equal volumes.

    Raises
    ------
    FolderError
        One of them holds no run, or nothing to draw.
    """
    from ..kinds.inflation.comparison import comparison

    _check(folder)
    _check(other)
    try:
        return comparison(folder / "beside.png", [(folder, other)])
    except NoPicture as error:
        raise FolderError(str(error)) from error


def draw_at_end(scene: AnyScene, folder: Path, record: RunRecord) -> Path | None:
    """overview.png of a run that has just ended; a failing picture must not lose the run."""
    path = None
    if not (scene.output.picture and scene.output.fields_every):
        record.skip("overview.png: switched off by output.picture or output.fields_every")
    else:
        try:
            with record.phase("picture"):
                path = KINDS[scene.kind].draw(folder, scene)
        except Exception as error:
            record.skip(f"overview.png: {type(error).__name__}: {error}")
    record.write()
    return path


def _check(folder: Path) -> None:
    if not (folder / "history.csv").exists():
        raise FolderError(f"{folder} holds no history.csv; is it a run folder?")
