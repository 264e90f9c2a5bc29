"""What all pictures share: frames to draw, cuts, figures without a window, whole files."""

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


ON_PLANE = 1e-9  # of the body's size: vertices this near count as lying on the plane


def clipped(
    points: np.ndarray, quads: np.ndarray, values: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray]:
    """Polygons of the part y >= 0 and the mean of ``values`` on each quadrilateral.

    Parameters
    ----------
    points : (n, 3) array
    quads : (m, 4) int array
    values : (n,) array

    Returns
    -------
    polygons : list of (k, 3) array
    means : (len(polygons),) array
    """
    points = _snapped(points)
    mean = values[quads].mean(axis=1)
    touched = np.flatnonzero((points[quads, 1] > 0.0).any(axis=1))
    polygons = [_upper(points[quads[q]]) for q in touched]
    return polygons, mean[touched]


def section(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Segments ``(k, 2, 3)`` in which the surface meets y = 0."""
    points = _snapped(points)
    y = points[quads, 1]
    polygons = (_upper(points[quad]) for quad in quads[(y > 0.0).any(axis=1)])
    segments = [
        (a, b)
        for polygon in polygons
        for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
        if a[1] == 0.0 and b[1] == 0.0
    ]
    return np.array(segments).reshape(-1, 2, 3)


def _snapped(points: np.ndarray) -> np.ndarray:
    points = np.array(points, dtype=float)
    points[np.abs(points[:, 1]) <= ON_PLANE * np.ptp(points, axis=0).max(), 1] = 0.0
    return points


def _upper(polygon: np.ndarray) -> np.ndarray:
    """Sutherland-Hodgman clipping of one polygon to y >= 0."""
    kept = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if a[1] >= 0.0:
            kept.append(a)
        if a[1] * b[1] < 0.0:
            crossing = a + a[1] / (a[1] - b[1]) * (b - a)
            kept.append(np.array([crossing[0], 0.0, crossing[2]]))
    return np.array(kept)
