"""Soft contact in space: a repulsive traction between facing sheets, after [T 4.14-4.20].

``Z(x) = z int b(r/l) max(0, |q.(n(x)-n(y))| - c) q / r^(alpha-2) dA_y``, q = (x-y)/r. Two sheets
at gap g << l feel, with k = c/2 and alpha = 5 (default), ``2 pi z/g [2/3 (1-k^3) - c/2 (1-k^2)]``:
it diverges. alpha = 4, the literal analogue of the plane kernel, stays bounded.
departs from [T 4.14]: the cut c removes the same sheet, whose kernel is odd and singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Repulsion:
    """Strength z, range l, exponent alpha and cut c.

    Raises
    ------
    ValueError
        A range or strength that is not positive.
    """

    strength: float
    range: float
    exponent: float = 5.0
    cut: float = 0.5

    def __post_init__(self) -> None:
        if not (self.strength > 0.0 and self.range > 0.0):
            raise ValueError("repulsion needs a positive strength and range")

    def forces(self, points: np.ndarray, normals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Force on each quadrature point ``(n, 3)``, weight included; the sum vanishes.

        Parameters
        ----------
        points, normals : (n, 3) array
        weights : (n,) array
            Quadrature weights with area element.
        """
        pairs = cKDTree(points).query_pairs(self.range, output_type="ndarray")
        force = np.zeros_like(points)
        if not len(pairs):
            return force
        i, j = pairs.T
        offset = points[i] - points[j]
        r = np.linalg.norm(offset, axis=1)
        q = offset / r[:, None]
        facing = np.abs(np.einsum("ij,ij->i", q, normals[i] - normals[j])) - self.cut
        size = self.strength * cutoff(r / self.range) * np.maximum(facing, 0.0)
        size = size / r ** (self.exponent - 2.0) * weights[i] * weights[j]
        np.add.at(force, i, size[:, None] * q)
        np.add.at(force, j, -size[:, None] * q)
        return force


def cutoff(s: np.ndarray) -> np.ndarray:
    """The thesis' cubic B-spline window, 1 at 0 and 0 beyond 1 [T 4.1.4]."""
    outer = 1.5 - 3.0 * s + 1.5 * s**2
    return np.where(s < 1.0 / 3.0, 1.0 - 3.0 * s**2, np.where(s < 1.0, outer, 0.0))
