"""What all pictures share: frames to draw, cuts, figures without a window, whole files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .vtk import read_frames

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

LIGHT = np.array([-0.3, -0.7, 0.65])  # direction the light comes from

GROWN = 1.35  # size of axes in space over that of their cell


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


def grown(place: Bbox) -> tuple[float, float, float, float]:
    """A cell of a figure's grid with the empty rim that axes in space have outside of it."""
    wide, tall = GROWN * place.width, GROWN * place.height
    x, y = 0.5 * (place.x0 + place.x1), 0.5 * (place.y0 + place.y1)
    return x - 0.5 * wide, y - 0.5 * tall, wide, tall


def save(figure: Figure, path: Path) -> Path:
    """Write a figure; an old file stays whole until the new one is."""
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
    touched = upper_cells(points, quads)
    polygons = [_upper(points[quads[q]]) for q in touched]
    return polygons, mean[touched]


def section(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Segments ``(k, 2, 3)`` in which the surface meets y = 0."""
    return section_with_cells(points, quads)[0]


def section_with_cells(points: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments of `section` and the quadrilateral ``(k,)`` that each is cut from."""
    points = _snapped(points)
    cells = upper_cells(points, quads)
    segments = [
        (a, b, q)
        for q, polygon in ((q, _upper(points[quads[q]])) for q in cells)
        for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
        if a[1] == 0.0 and b[1] == 0.0
    ]
    lines = np.array([(a, b) for a, b, _ in segments]).reshape(-1, 2, 3)
    return lines, np.array([q for *_, q in segments], dtype=int)


def upper_cells(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Quadrilaterals that reach above y = 0: those that `clipped` keeps, in its order."""
    return np.flatnonzero((_snapped(points)[quads, 1] > 0.0).any(axis=1))


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
            kept.append((a + a[1] / (a[1] - b[1]) * (b - a)) * [1.0, 0.0, 1.0])
    return np.array(kept)
