"""Flat triangles by their corners: sides, areas, normals and angles, for all steps to a bag."""

from __future__ import annotations

import numpy as np


def sides_of(triangles: np.ndarray) -> np.ndarray:
    """Vertices ``(m, 3, 2)`` at the start and the end of the sides 01, 12 and 20."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors ``(..., 3)`` of length 1; zeros stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def area_vectors(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Normals ``(m, 3)`` as long as the areas are large."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def facet_areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas ``(m,)``."""
    return np.asarray(np.linalg.norm(area_vectors(points, triangles), axis=1))


def facet_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals ``(m, 3)``; zero of triangles without area."""
    return unit(area_vectors(points, triangles))


def angles_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles ``(n,)`` between vectors ``(n, 3)``, in radians; exact for small and large ones."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))


def smallest_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Smallest angle ``(m,)`` of each triangle, in degrees."""
    corners = points[triangles]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(after, before), axis=2)
    angles = np.arctan2(sine, np.sum(after * before, axis=2))
    return np.asarray(np.degrees(angles.min(axis=1)))


def plane_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross product ``(...,)`` of vectors ``(..., 2)`` in a plane."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def plane_areas(plan: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas ``(m,)`` of triangles of points ``(n, 2)``, positive counterclockwise."""
    a, b, c = plan[triangles].transpose(1, 0, 2)
    return 0.5 * plane_cross(b - a, c - a)
