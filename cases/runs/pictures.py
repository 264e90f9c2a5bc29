"""The pictures of a run folder, made from its files alone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..kinds import KINDS
from ..output.atomic import RecordError
from ..output.figures import NoPicture
from ..output.run_record import RunRecord
from ..scene_text import differences
from ..sections import AnyScene
from .folder import FolderError, scene_of

if TYPE_CHECKING:
    from rich.console import Console

    from ..kinds.inflation.views.comparison import Comparison

# matplotlib's transforms of axes without data can overflow; nothing that is drawn depends on them
QUIET_TRANSFORMS = partial(np.errstate, over="ignore")


def draw(folder: Path) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    _check(folder)
    scene = scene_of(folder)
    with _drawing(folder):
        return KINDS[scene.kind].draw(folder, scene)


def animate(folder: Path) -> Path:
    """Draw animation.gif of a run folder.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    _check(folder)
    scene = scene_of(folder)
    with _drawing(folder):
        return KINDS[scene.kind].animate(folder)


def draw_loads(folder: Path) -> Path:
    """Draw loads.png of a run folder: contact pressure and wrinkled zones.

    Raises
    ------
    FolderError
        Frames without either.
    """
    from ..kinds.inflation.views.loads import loads

    _check(folder)
    with _drawing(folder):
        return loads(folder)


def compare(folder: Path, other: Path) -> Comparison:
    """Draw beside.png in ``folder``: both runs at equal volumes.

    Returns
    -------
    Comparison
        The last of its lines says what else than the model tells the two scenes apart.

    Raises
    ------
    FolderError
        One of them holds no run, or nothing to draw.
    """
    from ..kinds.inflation.views.comparison import comparison

    _check(folder)
    _check(other)
    unlike = differences(scene_of(folder), scene_of(other))
    with _drawing(folder):
        found = comparison(folder / "beside.png", folder, other)
    apart = f"keys that differ: {', '.join(unlike) or 'none'}"
    return replace(found, lines=(*found.lines, apart))


def draw_at_end(scene: AnyScene, folder: Path, record: RunRecord, console: Console) -> Path | None:
    """overview.png of a run that has just ended; a failing picture must not lose the run."""
    path = None
    if not (scene.output.picture and scene.output.fields_every):
        record.skip("overview.png: switched off by output.picture or output.fields_every")
    else:
        try:
            with record.phase("picture"), QUIET_TRANSFORMS():
                path = KINDS[scene.kind].draw(folder, scene)
        except Exception as error:
            what = f"overview.png: {type(error).__name__}: {error}"
            record.skip(what)
            console.print(f"skipped: {what}", markup=False, highlight=False)
    record.write()
    return path


@contextmanager
def _drawing(folder: Path) -> Iterator[None]:
    """Say in one line why the files of a folder make no picture."""
    try:
        with QUIET_TRANSFORMS():
            yield
    except OSError:
        raise
    except (NoPicture, RecordError) as error:
        raise FolderError(str(error)) from error
    except Exception as error:  # a damaged file can raise anything
        text = " ".join(str(error).split())
        raise FolderError(
            f"{folder} cannot be drawn, a file is damaged: {type(error).__name__}: {text}"
        ) from error


def _check(folder: Path) -> None:
    if not (folder / "history.csv").exists():
        raise FolderError(f"{folder} holds no history.csv; is it a run folder?")
