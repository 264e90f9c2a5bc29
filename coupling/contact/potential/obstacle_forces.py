"""Barrier of samples against an obstacle, ``kappa D sum_i w_i beta(d_i / D)``.

Obstacles move by prescription and may reach into the sheet from one time to the next: below a
tenth of the reach, and at negative distances, beta is continued by its quadratic, which pushes
out. The distance of a convex body is convex and its slope against the barrier negative, hence
``phi'' n n^T`` is the second derivative without its negative part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .barrier import barrier, contact_pressure
from .obstacles import Obstacle

FLOOR = 0.1  # of the reach: the quadratic begins


@dataclass(frozen=True)
class ObstacleForces:
    """What an obstacle does to the samples within reach of it.

    Parameters
    ----------
    samples : (k,) int array
    distance : (k,) array
        Negative inside of the obstacle.
    normal : (k, 3) array
        Out of the obstacle.
    areas : (k,) array
    reach, stiffness : float
    """

    samples: np.ndarray
    distance: np.ndarray
    normal: np.ndarray
    areas: np.ndarray
    reach: float
    stiffness: float

    @classmethod
    def of(
        cls,
        obstacle: Obstacle,
        points: np.ndarray,
        t: float,
        areas: np.ndarray,
        reach: float,
        stiffness: float,
    ) -> ObstacleForces:
        """Forces of an obstacle at a time on samples ``points (n, 3)`` of given areas ``(n,)``."""
        distance, normal = obstacle.distance(points, t)
        near = np.flatnonzero(distance < reach)
        return cls(near, distance[near], normal[near], areas[near], reach, stiffness)

    def energy(self) -> float:
        """Potential of the forces."""
        return float(self.stiffness * self.reach * self.areas @ self._barrier[0])

    def pressure(self) -> np.ndarray:
        """Force over area ``(k,)``."""
        return self.stiffness * contact_pressure(self.distance / self.reach, FLOOR)

    def gradients(self) -> np.ndarray:
        """Derivatives ``(k, 3)`` of the energy by the samples; forces are their negative."""
        return -(self.areas * self.pressure())[:, None] * self.normal

    def tangents(self) -> np.ndarray:
        """Second derivatives ``(k, 1, 3, 1, 3)`` without their negative part."""
        bend = self.stiffness / self.reach * self.areas * self._barrier[2]
        blocks = bend[:, None, None] * self.normal[:, :, None] * self.normal[:, None, :]
        return blocks[:, None, :, None, :]

    @property
    def _barrier(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return barrier(self.distance / self.reach, FLOOR)
