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
    parts = [
        _hits(origins[i : i + rows], directions[i : i + rows], triangles)
        for i in range(0, len(origins), rows)
    ]
    return np.concatenate(parts) if parts else np.empty(0)


def _hits(origins: np.ndarray, directions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(directions[:, None], c)
    det = np.sum(b * p, axis=2)
    det = np.where(det == 0.0, np.nan, det)  # parallel to the ray or collapsed: no hit
    to = origins[:, None] - a
    q = np.cross(to, b)
    u = np.sum(to * p, axis=2) / det
    v = np.sum(q * directions[:, None], axis=2) / det
    t = np.sum(c * q, axis=2) / det
    hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > OFF)
    return np.where(hit, t, np.inf).min(axis=1)
