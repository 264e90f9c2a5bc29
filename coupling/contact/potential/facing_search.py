"""Which triangle each sample faces, at any configuration.

Triangles that come near a sample are listed once with some slack, and the list serves until the
samples have moved by half of that, apart from a common translation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

OPPOSING = -0.3  # cosine of normals below which sheets face each other
SLACK = 2.0  # of the reach, by which listed triangles may be farther off than it


@dataclass(frozen=True)
class Facing:
    """Samples within reach of a triangle that faces them.

    Attributes
    ----------
    vertices : (k, 4) int array
        The sample and the corners of the triangle.
    weights : (k, 3) array
        Of the corners, for the closest point; exactly 0 off its edge or corner.
    outer : (k,) bool array
        Whether they face each other outside of the sheets.
    arrow : (k, 3) array
        From the closest point to the sample.
    distance : (k,) array
    """

    vertices: np.ndarray
    weights: np.ndarray
    outer: np.ndarray
    arrow: np.ndarray
    distance: np.ndarray


class FacingSearch:
    """Closest facing triangles of samples, with a list of candidates that is kept.

    Parameters
    ----------
    triangles : (m, 3) int array
        All turning the same way round the outward normal.
    reach : float
    """

    def __init__(self, triangles: np.ndarray, reach: float, slack: float = SLACK) -> None:
        # one layout and type: kernels are compiled once
        self.triangles = np.ascontiguousarray(triangles, dtype=np.int64)
        self.reach, self.slack = reach, slack * reach
        self.builds, self._room = 0, 0
        self._listed: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def facing(self, points: np.ndarray) -> Facing:
        """What faces each sample within reach, on either side.

        Parameters
        ----------
        points : (n, 3) array
        """
        from ._closest_feature_kernels import facing_features

        found, weights = facing_features(
            points, self.triangles, *self._candidates(points), self.reach, OPPOSING
        )
        sample, side = np.nonzero(found >= 0)
        corners = self.triangles[found[sample, side]]
        weights = weights[sample, side]
        arrow = points[sample] - np.einsum("kc,kcj->kj", weights, points[corners])
        vertices = np.concatenate([sample[:, None], corners], axis=1)
        return Facing(vertices, weights, side == 0, arrow, np.linalg.norm(arrow, axis=1))

    def _candidates(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles near each sample, listed anew where samples have moved too far."""
        if self._listed is not None:
            moved = points - self._listed[0]
            moved -= moved.mean(axis=0)
            if 4.0 * np.einsum("ij,ij->i", moved, moved).max() <= self.slack**2:
                return self._listed[1:]
        near = self._near(points)
        self._listed = points.copy(), *near
        self.builds += 1
        return near

    def _near(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        from ._closest_feature_kernels import by_point, near_pairs, sort_into_cells

        n, reach = len(points), self.reach + self.slack
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        width = max(reach, 1e-3 * float(extent.max()))
        while np.prod(extent / width + 1.0) > 8.0 * n + 64.0:
            width *= 1.25
        counts = (extent / width).astype(np.int64) + 1
        start, order = sort_into_cells(points, low, width, counts, np.empty(n, np.int64))
        self._room = max(self._room, 16 * n)
        while True:
            pairs = np.empty((self._room, 2), dtype=np.int32)
            found = near_pairs(
                points, self.triangles, reach, low, width, counts, start, order, pairs
            )
            if found <= self._room:
                begin, listed = by_point(pairs[:found], n)
                return begin, listed
            self._room = int(1.2 * found)
