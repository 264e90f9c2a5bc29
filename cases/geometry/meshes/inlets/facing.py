"""What a patch faces: rays from it outward to the nearest triangle of a surface."""

from __future__ import annotations

import numpy as np

CHUNK = 2_000_000  # pairs of rays and triangles at once
OFF = 1e-9  # hits nearer than this are where the ray starts


def first_hits(origins: np.ndarray, directions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distance along each ray to the nearest triangle (Moeller and Trumbore), infinite if none.

    Parameters
    ----------
    origins, directions : (n, 3) array
    triangles : (m, 3, 3) array

    Returns
    -------
    (n,) array
        In units of the directions' lengths.
    """
    rows = max(1, CHUNK // max(1, len(triangles)))
    found = np.full(len(origins), np.inf)
    for first in range(0, len(origins), rows):
        ray, triangle = _near(
            origins[first : first + rows], directions[first : first + rows], triangles
        )
        ray += first
        np.minimum.at(found, ray, _hits(origins[ray], directions[ray], triangles[triangle]))
    return found


def _near(
    origins: np.ndarray, directions: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of rays and triangles whose circumscribed balls the rays' lines meet."""
    middle = triangles.mean(axis=1)
    reach = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    centre = middle.mean(axis=0)
    c, o = middle - centre, origins - centre
    d = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    along = d @ c.T - np.sum(d * o, axis=1)[:, None]
    square = np.sum(c**2, axis=1) - 2.0 * o @ c.T + np.sum(o**2, axis=1)[:, None]
    rounding = 1e-12 * (np.sum(c**2, axis=1).max() + np.sum(o**2, axis=1).max())
    near = (square - along**2 <= reach**2 + rounding) & (along >= -reach)
    ray, triangle = np.nonzero(near)
    return ray, triangle


def _hits(origins: np.ndarray, directions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distance along each ray to its own triangle, infinite if it misses."""
    a, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(directions, c)
    det = np.sum(b * p, axis=1)
    det = np.where(det == 0.0, np.nan, det)  # parallel to the ray or collapsed: no hit
    to = origins - a
    q = np.cross(to, b)
    u, v = np.sum(to * p, axis=1) / det, np.sum(q * directions, axis=1) / det
    t = np.sum(c * q, axis=1) / det
    hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > OFF)
    return np.where(hit, t, np.inf)
