"""What all pictures share: frames to draw, a figure without a window, files replaced as a whole."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .vtk import read_frames

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIGHT = np.array([-0.3, -0.7, 0.65])  # direction the light comes from


class NoPicture(ValueError):
    """A run folder without anything to draw."""


def frames_of(folder: Path, least: int = 1) -> list[tuple[float, str]]:
    """Times and file names of a run's frames.

    Raises
    ------
    NoPicture
        Fewer than ``least``.
    """
    frames = read_frames(folder / "fields.pvd")
    if not frames:
        raise NoPicture(f"{folder} has no frames in fields.pvd; set output.fields_every above 0")
    if len(frames) < least:
        raise NoPicture(f"{folder} has too few frames in fields.pvd; lower output.fields_every")
    return frames


def new_figure(**options: Any) -> Figure:
    """A figure that draws to files; ``options`` are matplotlib's."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(**options)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a figure; the old file stays whole until the new one is complete."""
    part = path.with_name(f"{path.stem}.part{path.suffix}")
    figure.savefig(part)
    part.replace(path)
    return path
