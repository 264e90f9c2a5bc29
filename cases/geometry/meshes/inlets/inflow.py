"""The inflow over a patch of any outline: ``X = (d / d_max) (2 - d / d_max)``, d from its rim.

d is the distance from the rim's Bezier curve, so that no plane is needed and X is zero at the rim
of the smooth surface; on a disc it is the parabola. Elsewhere it is as smooth as d: its slope jumps
where two places of the rim are equally near.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from shells.surfaces.splines import bernstein

SAMPLES = 8  # points of each edge from which the nearest is sought
STARTS = 3  # nearest points that are refined: the edges on both sides of a vertex
ITERATIONS = 4  # of Newton's method for the foot of the perpendicular


class RimCurve:
    """A chain of Bezier edges.

    Parameters
    ----------
    control : (k, p + 1, 3) array
        Control points of each edge.
    """

    def __init__(self, control: np.ndarray):
        self.control = control
        self._t = (np.arange(SAMPLES) + 0.5) / SAMPLES
        points = bernstein(self.degree, self._t).T @ control
        self._tree = cKDTree(points.reshape(-1, 3))

    @property
    def degree(self) -> int:
        """Polynomial degree p."""
        return self.control.shape[1] - 1

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distances ``(n,)`` of points ``(n, 3)`` from the curve."""
        points = np.asarray(points, dtype=float)
        starts = min(STARTS, self._tree.n)
        _, near = self._tree.query(points, k=np.arange(1, starts + 1))
        edge, sample = np.divmod(near.ravel(), SAMPLES)
        at = np.repeat(points, starts, axis=0)
        t = self._t[sample]
        for _ in range(ITERATIONS):
            off, slope, bend = self._jets(edge, t, at)
            curvature = np.sum(slope**2 + off * bend, axis=1)
            steepest = np.maximum(curvature, 0.5 * np.sum(slope**2, axis=1))
            t = np.clip(t - np.sum(off * slope, axis=1) / steepest, 0.0, 1.0)
        away = np.linalg.norm(self._jets(edge, t, at)[0], axis=1)
        return away.reshape(-1, starts).min(axis=1)

    def _jets(self, edge: np.ndarray, t: np.ndarray, at: np.ndarray) -> list[np.ndarray]:
        """Offset from points, first and second derivative of the curve, ``(n, 3)`` each."""
        c = self.control[edge]
        found = [np.einsum("kn,nkc->nc", bernstein(self.degree, t, k), c) for k in range(3)]
        found[0] -= at
        return found


def inflow_profile(rim: RimCurve, patch: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Profile X of points ``(n, 3)`` on a patch, 1 where it is deepest and 0 at its rim.

    Parameters
    ----------
    rim : RimCurve
    patch : (k, 3) array
        Points all over the patch, among which the deepest is found.

    Returns
    -------
    callable
    """
    deepest = float(rim.distance(patch).max())

    def profile(points: np.ndarray) -> np.ndarray:
        x = rim.distance(points) / deepest
        # points between those of the patch may be deeper: flat there
        return np.where(x < 1.0, x * (2.0 - x), 1.0)

    return profile
