"""Rigid obstacles that sheets rest on or are pressed by: planes, cylinders and boxes.

Each is a convex body known by its signed distance, positive outside, and may move by a
prescribed translation. Samples of the sheet feel it, not their triangles: an edge or a cylinder
thinner than the distance of samples can pass between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

Motion = Callable[[float], ArrayLike]


def at_rest(t: float) -> np.ndarray:
    """The motion of what does not move."""
    return np.zeros(3)


class Obstacle(Protocol):
    """A convex rigid body."""

    def distance(self, points: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of points and its gradient.

        Parameters
        ----------
        points : (n, 3) array
        t : float

        Returns
        -------
        (n,) array and (n, 3) array
        """


@dataclass(frozen=True)
class PlaneObstacle:
    """The half-space behind a plane.

    Parameters
    ----------
    point : (3,) array_like
    normal : (3,) array_like
        Into the free space; any length.
    motion : callable
        Displacement ``(3,)`` at a time; default at rest.
    """

    point: ArrayLike
    normal: ArrayLike
    motion: Motion = field(default=at_rest)

    def distance(self, points: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance ``(n,)`` and its gradient ``(n, 3)``."""
        normal = unit(self.normal)
        away = (points - self.point - np.asarray(self.motion(t))) @ normal
        return away, np.broadcast_to(normal, points.shape)


@dataclass(frozen=True)
class CylinderObstacle:
    """A solid cylinder without ends.

    Parameters
    ----------
    point, axis : (3,) array_like
        A point of the axis and its direction.
    radius : float
    motion : callable
        Displacement ``(3,)`` at a time; default at rest.
    """

    point: ArrayLike
    axis: ArrayLike
    radius: float
    motion: Motion = field(default=at_rest)

    def distance(self, points: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance ``(n,)`` and its gradient ``(n, 3)``."""
        axis = unit(self.axis)
        away = points - self.point - np.asarray(self.motion(t))
        away -= np.outer(away @ axis, axis)
        length = np.linalg.norm(away, axis=1)
        return length - self.radius, away / np.maximum(length, 1e-300)[:, None]


@dataclass(frozen=True)
class BoxObstacle:
    """A solid box.

    Parameters
    ----------
    centre, half_sizes : (3,) array_like
    axes : (3, 3) array_like
        Directions of its edges in rows, orthonormal; default those of space.
    motion : callable
        Displacement ``(3,)`` at a time; default at rest.

    Raises
    ------
    ValueError
        Axes that are not orthonormal.
    """

    centre: ArrayLike
    half_sizes: ArrayLike
    axes: ArrayLike = field(default_factory=lambda: np.eye(3))
    motion: Motion = field(default=at_rest)

    def __post_init__(self) -> None:
        axes = np.asarray(self.axes, dtype=float)
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9):
            raise ValueError("the axes of a box must be orthonormal rows")

    def distance(self, points: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance ``(n,)`` and its gradient ``(n, 3)``."""
        axes = np.asarray(self.axes, dtype=float)
        local = (points - self.centre - np.asarray(self.motion(t))) @ axes.T
        beyond = np.abs(local) - self.half_sizes
        out = np.maximum(beyond, 0.0)
        length = np.linalg.norm(out, axis=1)
        nearest = np.eye(3)[beyond.argmax(axis=1)]
        inside = length == 0.0
        direction = np.where(inside[:, None], nearest, out / np.where(inside, 1.0, length)[:, None])
        away = np.where(inside, beyond.max(axis=1), length)
        return away, np.where(local < 0.0, -direction, direction) @ axes


def unit(direction: ArrayLike) -> np.ndarray:
    """A direction of length 1.

    Raises
    ------
    ValueError
        A direction of length 0.
    """
    length = float(np.linalg.norm(direction))
    if not length > 0.0:
        raise ValueError("a direction needs a length")
    return np.asarray(direction, dtype=float) / length
