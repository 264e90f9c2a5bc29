"""Near pairs: which (outer point, element) pairs need an accurate rule, and where they are close.

Candidates come from balls around the elements; the closest point decides:
``b_i = d / max(|x_i|, radius / 2)``, near if ``min(b_1, b_2) <= 1``. Both depend on distances
within the scene alone, so a rotated scene gives the same pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from . import _near_kernels as kernels
from .quadrature import QuadratureOrders
from .sampling import SampledSurface


@dataclass(frozen=True)
class NearPairs:
    """Near pairs of some points, by point.

    Attributes
    ----------
    points : (n_points, 3) array
    indptr : (n_points + 1,) int array
    elements : (n_pairs,) int array
        Source element of each pair, increasing within a point.
    found : (n_pairs, 4) array
        Closest point s, t and relative distances b1, b2; negative on the point's own element.
    """

    points: np.ndarray
    indptr: np.ndarray
    elements: np.ndarray
    found: np.ndarray

    @property
    def n_pairs(self) -> int:
        return self.elements.size

    def part(self, points: slice) -> NearPairs:
        """The pairs of a range of points."""
        inside = slice(self.indptr[points.start], self.indptr[points.stop])
        indptr = self.indptr[points.start : points.stop + 1] - inside.start
        return NearPairs(self.points[points], indptr, self.elements[inside], self.found[inside])


def outer_pairs(surface: SampledSurface, orders: QuadratureOrders, points: slice) -> NearPairs:
    """Near pairs of a range of outer points, their own elements included."""
    x = np.ascontiguousarray(surface.outer.points[points])
    owners = np.arange(surface.outer.points.shape[0])[points] // surface.outer.per_element
    return near_pairs(surface, x, owners, orders.near_ball)


def near_pairs(
    surface: SampledSurface, x: np.ndarray, owners: np.ndarray, near_ball: float
) -> NearPairs:
    """Near pairs of points ``x (n, 3)``.

    ``owners (n,)`` names the element on which a point is an outer Gauss point; -1 for points
    off the surface.
    """
    indptr, elements = _candidates(surface, near_ball, x, owners)
    found = np.empty((elements.size, 4))
    n = surface.centres.shape[0]
    kernels.classify(
        x,
        owners,
        indptr,
        elements,
        surface.control,
        surface.outer.points.reshape(n, -1, 3),
        np.stack([surface.outer.s, surface.outer.t]),
        surface.radii,
        found,
    )
    near = found[:, 2:].min(axis=1) <= 1.0
    kept = np.concatenate([[0], np.cumsum(near)])[indptr]
    return NearPairs(x, kept, elements[near], found[near])


def _candidates(
    surface: SampledSurface, near_ball: float, x: np.ndarray, owners: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs within ``1 + near_ball`` radii of a centre, as index pointer and elements.

    The tree only preselects; the exact test is the distance, computed as rotations leave it.
    """
    reach = (1.0 + near_ball) * surface.radii
    hits = cKDTree(x).query_ball_point(surface.centres, 1.0000001 * reach, return_sorted=False)
    counts = np.fromiter((len(h) for h in hits), np.int64, len(hits))
    points = np.concatenate([np.asarray(h, np.int64) for h in hits])
    elements = np.repeat(np.arange(counts.size), counts)
    away = x[points] - surface.centres[elements]
    inside = np.einsum("ij,ij->i", away, away) < reach[elements] ** 2
    inside |= owners[points] == elements
    own = np.flatnonzero(owners >= 0)
    keys = np.concatenate(
        [points[inside] * counts.size + elements[inside], own * counts.size + owners[own]]
    )
    points, elements = np.divmod(np.unique(keys), counts.size)
    return np.searchsorted(points, np.arange(x.shape[0] + 1)), elements
