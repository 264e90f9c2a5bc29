"""Near triangles contracted at another vertex: the one farthest from the closest point.

There the collapsed coordinate lines, which crowd at the contracted vertex, do no harm.
"""

from __future__ import annotations

import numpy as np

from ..surfaces.bernstein import tensor_bernstein_gradient
from ..surfaces.surface_points import PatchShapes, SampledSurface
from ..surfaces.triangles import barycentric
from ._closest_point_kernels import OBLIQUE
from .closest_point import ClosestPoints


def rotate_vertices(
    closest: ClosestPoints,
    elements: np.ndarray,
    vertex: int,
    old: SampledSurface,
    new: PatchShapes,
) -> ClosestPoints:
    """Closest points of some pairs in coordinates contracted at another vertex.

    ``old`` is contracted at vertex 0, ``new`` at ``vertex``.
    """
    _, old_s, old_t = _tangents(old.control[elements], closest.s, closest.t)
    u, v, w = np.roll(barycentric(closest.s, closest.t), -vertex, axis=1).T
    out = closest.rows.copy()
    out[:, 0], out[:, 1] = 1.0 - u, w / (v + w)
    cosine, new_s, new_t = _tangents(new.control[elements], out[:, 0], out[:, 1])
    floor = 0.5 * old.radii[elements]
    out[:, 2] *= np.maximum(old_s, floor) / np.maximum(new_s, floor)
    out[:, 3] *= np.maximum(old_t, floor) / np.maximum(new_t, floor)
    short = np.minimum(new_s, new_t) < floor
    angle = np.where(short, 0.5 * np.pi, np.arccos(np.minimum(cosine, 1.0)))
    out[:, 4] = np.minimum(OBLIQUE, 0.5 * np.pi / np.maximum(angle, 1e-3))
    return ClosestPoints(out)


def _tangents(
    control: np.ndarray, s: np.ndarray, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cosine between the coordinate lines at closest points, and their speeds."""
    flat = control.reshape(len(control), -1, 3)
    tables = tensor_bernstein_gradient(control.shape[1] - 1, s, t)
    a, b = (np.einsum("nk,nkc->nc", table, flat) for table in tables)
    along_s, along_t = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
    both = np.maximum(along_s * along_t, 1e-300)
    return np.abs(np.sum(a * b, axis=1)) / both, along_s, along_t
