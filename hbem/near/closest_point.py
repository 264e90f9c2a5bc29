"""Near pairs: which (outer point, element) pairs need an accurate rule, and where they are close.

Candidates come from balls around the elements; the closest point decides:
``b_i = d / max(|x_i|, radius / 2)``, near if ``min(b_1, b_2) <= 1``. Both depend on distances
within the scene alone, so a rotated scene gives the same pairs. Newton's closest point is kept
if it is stationary and nearer than `ElementPieces.flat` (within the radius of curvature);
elsewhere a search certifies it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .._threads_kernels import over, threads
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface
from . import _closest_point_kernels as kernels


@dataclass(frozen=True)
class ClosestPoints:
    """Closest points of near pairs, a row each as the kernels keep them.

    Attributes
    ----------
    rows : (n, 5) array
        Local coordinates s, t; relative distances ``b_i = d / |x_i|``, negative on the piece on
        which the point lies; a right angle over that of the coordinate lines.
    """

    rows: np.ndarray

    def __getitem__(self, pairs: np.ndarray | slice) -> ClosestPoints:
        return ClosestPoints(self.rows[pairs])

    @property
    def s(self) -> np.ndarray:
        return self.rows[:, 0]

    @property
    def t(self) -> np.ndarray:
        return self.rows[:, 1]

    @property
    def distances(self) -> np.ndarray:
        """Relative distances along s and t, ``(n, 2)``."""
        return self.rows[:, 2:4]


@dataclass(frozen=True)
class NearPairs:
    """Near pairs of some points, by point; one for each piece of a near element.

    Attributes
    ----------
    points : (n_points, 3) array
        Relative to the origin of the surface.
    indptr : (n_points + 1,) int array
    elements : (n_pairs,) int array
        Source element of each pair, increasing within a point.
    boxes : (n_pairs, 4) array
        The piece of it in its local coordinates, as in `ElementPieces`.
    closest : ClosestPoints
        In the coordinates of the elements.
    first : (n_pairs,) bool array
        First piece of its element.
    """

    points: np.ndarray
    indptr: np.ndarray
    elements: np.ndarray
    boxes: np.ndarray
    closest: ClosestPoints
    first: np.ndarray

    @property
    def n_pairs(self) -> int:
        return self.elements.size

    def part(self, points: slice) -> NearPairs:
        """The pairs of a range of points."""
        k = slice(self.indptr[points.start], self.indptr[points.stop])
        indptr = self.indptr[points.start : points.stop + 1] - k.start
        return NearPairs(
            self.points[points],
            indptr,
            self.elements[k],
            self.boxes[k],
            self.closest[k],
            self.first[k],
        )


def outer_pairs(surface: SampledSurface, orders: QuadratureOrders, points: slice) -> NearPairs:
    """Near pairs of a range of outer points (whole elements), their own elements included."""
    x = np.ascontiguousarray(surface.outer.offsets[points])
    owners = np.arange(surface.outer.offsets.shape[0])[points] // surface.outer.per_element
    return near_pairs(surface, x, owners, orders.near_ball)


def near_pairs(
    surface: SampledSurface, x: np.ndarray, owners: np.ndarray, near_ball: float
) -> NearPairs:
    """Near pairs of points ``x (n, 3)``, relative to the origin of the surface.

    ``owners (n,)`` names the element on which a point is an outer Gauss point, points of an
    element following each other; -1 for points off the surface.
    """
    pieces = surface.pieces
    points, elements = _candidates(surface, near_ball, x, owners)
    counts = np.diff(pieces.indptr)[elements]
    starts = np.cumsum(counts) - counts
    which = np.arange(counts.sum()) - np.repeat(starts - pieces.indptr[elements], counts)
    point_of = np.repeat(points, counts)
    rows = np.empty((which.size, 5))
    over(
        x.shape[0],
        kernels.classify,
        surface.shapes.powers,
        x,
        owners,
        np.searchsorted(point_of, np.arange(x.shape[0] + 1)),
        which,
        pieces.elements,
        pieces.boxes,
        surface.control,
        pieces.nets,
        surface.search_points,
        np.stack([surface.outer.s, surface.outer.t]),
        np.stack([surface.outer.s, surface.outer.t]),
        pieces.radii,
        pieces.flat,
        pieces.convexity,
        pieces.speeds,
        rows,
    )
    closest = ClosestPoints(rows)
    near = (closest.distances <= 1.0).any(axis=1)
    near = np.repeat(np.logical_or.reduceat(near, starts), counts)
    indptr = np.searchsorted(point_of[near], np.arange(x.shape[0] + 1))
    first = np.zeros(which.size, bool)
    first[starts] = True
    which = which[near]
    elements, boxes = pieces.elements[which], pieces.boxes[which]
    return NearPairs(x, indptr, elements, boxes, closest[near], first[near])


def _candidates(
    surface: SampledSurface, near_ball: float, x: np.ndarray, owners: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points and elements with a piece within ``1 + near_ball`` radii of its element, by point.

    The tree only preselects; the exact test is the distance, computed as rotations leave it.
    """
    pieces, n = surface.pieces, surface.patches.n_elements
    reach = (1.0 + near_ball) * surface.radii[pieces.elements]
    hits = cKDTree(x).query_ball_point(
        pieces.centres, 1.0000001 * reach, return_sorted=False, workers=threads()
    )
    counts = np.fromiter((len(h) for h in hits), np.int64, len(hits))
    points = np.concatenate([np.asarray(h, np.int64) for h in hits])
    which = np.repeat(np.arange(counts.size), counts)
    away = x[points] - pieces.centres[which]
    inside = (away**2).sum(axis=1) < reach[which] ** 2
    own = np.flatnonzero(owners >= 0)
    keys = np.concatenate(
        [points[inside] * n + pieces.elements[which[inside]], own * n + owners[own]]
    )
    keys.sort()
    return np.divmod(keys[np.diff(keys, prepend=-1) > 0], n)
