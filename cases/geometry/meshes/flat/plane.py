"""The plane of a flat pattern: least squares, then midway between its two sheets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..facet_mesh import MeshError

EVEN = 1e-9  # of the size: flatter than this needs no second fit


@dataclass(frozen=True)
class PatternPlane:
    """Coordinates of a flat pattern: two in its plane, the third off it.

    Attributes
    ----------
    origin : (3,) array
        A point of the plane.
    axes : (3, 3) array
        Orthonormal, right-handed rows: two in the plane, then its normal.
    thickness : float
        Extent of the points along the normal.
    size : float
        Largest extent of the points in the plane.
    """

    origin: np.ndarray
    axes: np.ndarray
    thickness: float
    size: float

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        """Coordinates ``(n, 3)`` of points in space."""
        return (points - self.origin) @ self.axes.T


def fitted_plane(points: np.ndarray) -> PatternPlane:
    """Plane midway between the sheets that hold ``points (n, 3)``.

    The least squares plane leans to where one sheet has more points than the other; the plane
    of the smallest largest distance lies between parallel sheets however they are meshed.

    Raises
    ------
    MeshError
        Points on a line.
    """
    origin = points.mean(axis=0)
    _, extents, axes = np.linalg.svd(points - origin, full_matrices=False)
    if not extents[1] > 1e-9 * extents[0]:
        raise MeshError(
            "all points lie on one line, a pattern needs a plane; export the whole pattern"
        )
    axes = _signed(axes)
    x = (points - origin) @ axes.T
    size = float(np.ptp(x[:, :2], axis=0).max())
    if np.ptp(x[:, 2]) > EVEN * size:
        slope, height = _midway(x)
        origin = origin + height * axes[2]
        normal = axes[2] - slope @ axes[:2]
        normal /= np.linalg.norm(normal)
        first = axes[0] - (axes[0] @ normal) * normal
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(normal, first), normal])
    return PatternPlane(origin, axes, float(np.ptp((points - origin) @ axes[2])), size)


def _signed(axes: np.ndarray) -> np.ndarray:
    """The same axes right-handed, with a normal whose largest component is positive."""
    normal = axes[2] * np.sign(axes[2][np.abs(axes[2]).argmax()])
    return np.stack([axes[0], np.cross(normal, axes[0]), normal])


def _midway(x: np.ndarray) -> tuple[np.ndarray, float]:
    """Slope and height of ``z = slope . (x, y) + height`` of smallest largest distance."""
    from scipy.optimize import linprog

    ones = np.ones((x.shape[0], 1))
    plane = np.column_stack([x[:, :2], ones])
    bounds = np.block([[plane, -ones], [-plane, -ones]])
    found = linprog(
        [0.0, 0.0, 0.0, 1.0],
        A_ub=bounds,
        b_ub=np.concatenate([x[:, 2], -x[:, 2]]),
        bounds=[(None, None)] * 3 + [(0.0, None)],
    )
    return np.asarray(found.x[:2]), float(found.x[2])
