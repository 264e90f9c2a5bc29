"""The narrowest distance of sheets that face each other, sampled: what fluid and contact will meet.

Neighbours in six dimensions, points and scaled normals: the nearest sample of opposite normal.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shells.surfaces.local_elements import functions, rule

OPPOSITE = -0.9  # cosine of facing normals
AHEAD = 0.9  # cosine between a normal and the way to what it faces
NEIGHBOURS = 6
WEIGHT = 2.0  # of normals: a place itself is as far as four gaps


def narrowest_gap(
    control: np.ndarray, degree: int, gap: float, beside: np.ndarray | None = None
) -> float:
    """Smallest distance between facing places of Bezier triangles, see `facing_distances`.

    Triangles ``beside (m,) bool`` a seam, where the gap closes in any case, do not count.
    """
    across = facing_distances(control, degree, gap)[1].reshape(control.shape[0], -1)
    counted = across if beside is None else across[~beside]
    return float(counted.min(initial=np.inf))


def facing_distances(control: np.ndarray, degree: int, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Distance from places of Bezier triangles to what faces them, inside and outside.

    Parameters
    ----------
    control : (m, n_functions, 3) array
    degree : int
    gap : float
        A typical distance, against which normals are weighed.

    Returns
    -------
    places : (k m, 3) array
        k of each triangle, one triangle after the other.
    distances : (k m,) array
        Infinite where nothing faces a place.
    """
    xi, eta, _ = rule("triangle", 2)
    x, s, t = (
        (functions("triangle", degree, xi, eta, order) @ control).reshape(-1, 3)
        for order in ((0, 0), (1, 0), (0, 1))
    )
    normals = np.cross(s, t)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    weighed = WEIGHT * gap * normals
    tree = cKDTree(np.hstack([x, weighed]))
    k = min(NEIGHBOURS, len(x))
    _, near = tree.query(np.hstack([x, -weighed]), k=np.arange(1, k + 1))
    way = x[near] - x[:, None]
    across = np.abs(np.einsum("ijc,ic->ij", way, normals))
    facing = np.einsum("ijc,ic->ij", normals[near], normals) < OPPOSITE
    facing &= across > AHEAD * np.linalg.norm(way, axis=2)
    return x, np.where(facing, across, np.inf).min(axis=1)
