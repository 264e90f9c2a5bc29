"""Smallest gap between facing parts of a surface, from samples.

Nearest neighbours are sought among points with opposing normals: a KD-tree in six dimensions on
``(x, s n)`` queried at ``(x, -s n)``. The gap is measured along the mean normal, so that samples
need not lie exactly opposite each other.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

NEIGHBOURS = 6
FACING = -0.9  # cosine between facing normals: walls of a fold tip do not count


def minimum_gap(points: np.ndarray, normals: np.ndarray, scale: float) -> float:
    """Find the smallest distance between facing sheets.

    Parameters
    ----------
    points, normals : (n, 3) array
        Samples and unit outward normals.
    scale : float
        Expected gap; weighs the opposition of normals against distance.

    Returns
    -------
    float
        Infinity if no two samples face each other.
    """
    weight = 2.0 * scale
    tree = cKDTree(np.hstack([points, weight * normals]))
    k = min(NEIGHBOURS, points.shape[0])
    _, index = tree.query(np.hstack([points, -weight * normals]), k=k)
    index = index.reshape(points.shape[0], -1)
    facing = np.einsum("ic,ijc->ij", normals, normals[index]) < FACING
    offset = points[index] - points[:, None]
    mean = normals[:, None] - normals[index]
    length = np.linalg.norm(mean, axis=-1)
    length = np.where(length > 0.0, length, 1.0)
    gap = np.abs(np.einsum("ijc,ijc->ij", offset, mean)) / length
    lateral = np.sqrt(np.maximum(np.einsum("ijc,ijc->ij", offset, offset) - gap**2, 0.0))
    valid = facing & (lateral <= np.maximum(gap, _spacing(points)))
    return float(gap[valid].min()) if valid.any() else float("inf")


def _spacing(points: np.ndarray) -> float:
    """Largest distance from a sample to its nearest neighbour."""
    distance, _ = cKDTree(points).query(points, k=2)
    return float(distance[:, 1].max())
