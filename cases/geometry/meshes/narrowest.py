"""The narrowest distance of sheets that face each other, sampled: what fluid and contact will meet.

Neighbours among the samples whose normals go against the largest component of the own one.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shells.surfaces.local_elements import functions, rule

OPPOSITE = -0.9  # cosine of facing normals
AHEAD = 0.9  # cosine between a normal and the way to what it faces
TURNED = -0.16  # along the largest component of a normal, which all that faces it lies below
NEIGHBOURS = 12
REACH = 1.8  # gaps up to which something faces a place; most of a round body is farther apart


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
        A typical distance; what is farther than 1.8 of it is not seen.

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
    distances = np.full(len(x), np.inf)
    side = np.argmax(np.abs(normals), axis=1)
    upwards = np.take_along_axis(normals, side[:, None], axis=1)[:, 0] > 0.0
    for axis in range(3):
        for up in (False, True):
            asking = np.flatnonzero((side == axis) & (upwards == up))
            against = normals[:, axis] * (1 if up else -1) < TURNED
            found = _nearest(x, normals, asking, np.flatnonzero(against), REACH * gap)
            distances[asking] = found
    return x, distances


def _nearest(
    x: np.ndarray, normals: np.ndarray, asking: np.ndarray, against: np.ndarray, reach: float
) -> np.ndarray:
    """Distances of some places to the nearest of others that face them, up to a reach."""
    if not (asking.size and against.size):
        return np.full(asking.size, np.inf)
    k = np.arange(1, min(NEIGHBOURS, against.size) + 1)
    _, near = cKDTree(x[against]).query(x[asking], k=k, distance_upper_bound=reach)
    none = near == against.size
    other = against[np.where(none, 0, near)]
    way, n = x[other] - x[asking][:, None], normals[asking]
    across = np.abs(np.einsum("ijc,ic->ij", way, n))
    facing = ~none & (np.einsum("ijc,ic->ij", normals[other], n) < OPPOSITE)
    facing &= across > AHEAD * np.linalg.norm(way, axis=2)
    return np.where(facing, across, np.inf).min(axis=1)
