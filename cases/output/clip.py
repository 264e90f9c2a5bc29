"""Cutting a surface of quadrilaterals open along the plane y = 0."""

from __future__ import annotations

import numpy as np

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
