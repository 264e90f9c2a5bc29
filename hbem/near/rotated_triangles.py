"""Triangles rotated so that the vertex nearest to the target comes first."""

from __future__ import annotations

import numpy as np

from ..surfaces.bernstein import tensor_bernstein_gradient
from ..surfaces.triangles import barycentric
from ._closest_point_kernels import OBLIQUE


def turned(found: np.ndarray, elements: np.ndarray, vertex: int, old, new) -> np.ndarray:
    """`NearPairs.found` of some pairs in coordinates contracted at another vertex.

    ``old`` and ``new`` are the `SampledSurface` contracted at vertices 0 and ``vertex``.
    """
    _, old_s, old_t = _tangents(old.control[elements], found)
    u, v, w = np.roll(barycentric(found), -vertex, axis=1).T
    out = found.copy()
    out[:, 0], out[:, 1] = 1.0 - u, w / (v + w)
    cosine, new_s, new_t = _tangents(new.control[elements], out)
    floor = 0.5 * old.radii[elements]
    out[:, 2] *= np.maximum(old_s, floor) / np.maximum(new_s, floor)
    out[:, 3] *= np.maximum(old_t, floor) / np.maximum(new_t, floor)
    short = np.minimum(new_s, new_t) < floor
    angle = np.where(short, 0.5 * np.pi, np.arccos(np.minimum(cosine, 1.0)))
    out[:, 4] = np.minimum(OBLIQUE, 0.5 * np.pi / np.maximum(angle, 1e-3))
    return out


def _tangents(control: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, ...]:
    """Cosine between the coordinate lines at closest points, and their speeds."""
    flat = control.reshape(len(control), -1, 3)
    tables = tensor_bernstein_gradient(control.shape[1] - 1, found[:, 0], found[:, 1])
    a, b = (np.einsum("nk,nkc->nc", table, flat) for table in tables)
    along_s, along_t = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
    both = np.maximum(along_s * along_t, 1e-300)
    return np.abs(np.sum(a * b, axis=1)) / both, along_s, along_t
