"""Smallest gap between facing parts of a surface, from its triangles.

Nearest neighbours are sought among triangles with opposing normals: a KD-tree in six dimensions
on ``(x, s n)`` queried at ``(x, -s n)``. Their distance is that of the triangles themselves:
samples need not lie opposite each other, and sheets may be tilted against each other.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .triangle_distance import triangle_distances

NEIGHBOURS = 6
BATCH = 256  # pairs whose distance is found at once, likely closest first
ROUNDING = 1e-12
FACING = -0.9  # cosine between facing normals: walls of a fold tip do not count


def facing_pairs(points: np.ndarray, triangles: np.ndarray, scale: float) -> np.ndarray:
    """Pairs of triangles that face each other and are among each other's nearest.

    Parameters
    ----------
    points : (n, 3) array
    triangles : (m, 3) int array
        All turning the same way round the outward normal.
    scale : float
        Expected gap; weighs the opposition of normals against distance.

    Returns
    -------
    (k, 2) int array
        Without pairs that share a vertex.
    """
    corners = points[triangles]
    centre, normal = corners.mean(axis=1), unit_normals(corners)
    weight = 2.0 * scale
    tree = cKDTree(np.hstack([centre, weight * normal]))
    k = min(NEIGHBOURS, len(triangles))
    _, index = tree.query(np.hstack([centre, -weight * normal]), k=k)
    i, j = np.repeat(np.arange(len(triangles)), k), index.ravel()
    facing = np.einsum("ij,ij->i", normal[i], normal[j]) < FACING
    i, j = i[facing], j[facing]
    apart = ~(triangles[i][:, :, None] == triangles[j][:, None, :]).any(axis=(1, 2))
    return np.stack([i[apart], j[apart]], axis=1)


def minimum_gap(points: np.ndarray, triangles: np.ndarray, scale: float) -> float:
    """Find the smallest distance between facing sheets.

    Parameters
    ----------
    points : (n, 3) array
    triangles : (m, 3) int array
        All turning the same way round the outward normal.
    scale : float
        Expected gap; weighs the opposition of normals against distance.

    Returns
    -------
    float
        Infinity if no two triangles face each other.
    """
    i, j = facing_pairs(points, triangles, scale).T
    if not i.size:
        return float("inf")
    corners = points[triangles]
    least = _lower_bounds(corners, i, j)
    order, best = np.argsort(least), np.inf
    for start in range(0, order.size, BATCH):
        batch = order[start : start + BATCH]
        if least[batch[0]] >= (1.0 - ROUNDING) * best:
            break
        distances = triangle_distances(corners[i[batch]], corners[j[batch]])
        best = min(best, float(distances.min()))
    return best


def _lower_bounds(corners: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """How far pairs of triangles at least are apart: corners of one from the plane of the other."""
    centre, normal = corners.mean(axis=1), unit_normals(corners)
    heights = []
    for a, b in ((i, j), (j, i)):
        level = np.einsum("pc,pc->p", normal[a], centre[a])
        above = np.einsum("pkc,pc->kp", corners[b], normal[a]) - level
        heights.append(np.maximum(above.min(axis=0), -above.max(axis=0)))
    return np.maximum(*heights)


def unit_normals(corners: np.ndarray) -> np.ndarray:
    """Unit normals ``(m, 3)`` of triangles with corners ``(m, 3, 3)``; 0 where one has no area."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return normal / np.where(length > 0.0, length, 1.0)
