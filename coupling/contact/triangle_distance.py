"""Distances of disjoint triangles in space, many pairs at once.

The distance of two triangles that do not intersect is attained between a corner and a face or
between two edges: six and nine candidates a pair [Ericson, Real-Time Collision Detection, 5.1].
"""

from __future__ import annotations

import numpy as np


def triangle_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances ``(k,)`` of triangles ``a[i]`` and ``b[i]``, corners ``(k, 3, 3)``.

    Intersecting triangles get an upper bound of their depth, not 0.
    """
    best = np.full(len(a), np.inf)
    for i in range(3):
        best = np.minimum(best, _point_triangle(a[:, i], b))
        best = np.minimum(best, _point_triangle(b[:, i], a))
        for j in range(3):
            edges = a[:, i], a[:, (i + 1) % 3], b[:, j], b[:, (j + 1) % 3]
            best = np.minimum(best, _segments(*edges))
    return np.sqrt(best)


def _dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", u, v)


def _ratio(top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    return top / np.where(bottom > 0.0, bottom, 1.0)


def _point_triangle(p: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Squared distance from the face's plane where the foot lies inside, else infinity."""
    a, u, v = triangle[:, 0], *(triangle[:, k] - triangle[:, 0] for k in (1, 2))
    w = p - a
    uu, uv, vv, wu, wv = _dot(u, u), _dot(u, v), _dot(v, v), _dot(w, u), _dot(w, v)
    area = uu * vv - uv**2
    s, t = _ratio(vv * wu - uv * wv, area), _ratio(uu * wv - uv * wu, area)
    normal = np.cross(u, v)
    height = _ratio(_dot(w, normal) ** 2, _dot(normal, normal))
    inside = (area > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
    return np.where(inside, height, np.inf)


def _segments(p: np.ndarray, p1: np.ndarray, q: np.ndarray, q1: np.ndarray) -> np.ndarray:
    """Squared distance of two segments."""
    u, v, w = p1 - p, q1 - q, p - q
    uu, uv, vv, uw, vw = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    det = uu * vv - uv**2
    parallel = det <= 1e-12 * uu * vv
    s = np.clip(np.where(parallel, 0.0, _ratio(uv * vw - vv * uw, det)), 0.0, 1.0)
    t = np.clip(_ratio(uv * s + vw, vv), 0.0, 1.0)
    s = np.clip(_ratio(uv * t - uw, uu), 0.0, 1.0)
    gap = w + s[:, None] * u - t[:, None] * v
    return _dot(gap, gap)
