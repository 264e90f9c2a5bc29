"""Stokes flow inside a polygon, ``(1/2 + K) u = V t`` at unit viscosity, and its field inside.

Continuous linear velocities, discontinuous linear tractions. Off the boundary the integrals over
a segment are closed forms in the point's local coordinates ``x - y = -u t + h n``. The logarithm
is scaled, ``log(s / r)``, so that V stays definite for polygons smaller than s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .stokes import stokes_layers

TINY = 1e-13


@dataclass(frozen=True)
class PolygonStokes:
    """Operators of one polygon.

    Parameters
    ----------
    vertices : (m, 2) array
        Counterclockwise, closed by itself.
    scale : float
        s in ``log(s / r)``.
    """

    vertices: np.ndarray
    scale: float = 100.0

    @cached_property
    def _ends(self) -> np.ndarray:
        return np.roll(self.vertices, -1, axis=0)

    @cached_property
    def lengths(self) -> np.ndarray:
        """Of the segments ``(m,)``."""
        return np.linalg.norm(self._ends - self.vertices, axis=1)

    @cached_property
    def _tested(self) -> tuple[np.ndarray, np.ndarray]:
        """V and K tested with tractions, both for discontinuous linear functions."""
        single, double = stokes_layers(self.vertices, log_radius=self.scale)
        assert double is not None  # it is left out on request only
        return single, double

    @property
    def single(self) -> np.ndarray:
        """V, ``(4 m, 4 m)``."""
        return self._tested[0]

    @cached_property
    def double(self) -> np.ndarray:
        """1/2 + K, ``(4 m, 2 m)``."""
        m = self.lengths.size
        mass = np.zeros((m, 2, 2, m, 2))
        k = np.arange(m)
        for row in range(2):
            for column in range(2):
                weight = self.lengths * (1.0 / 3.0 if row == column else 1.0 / 6.0)
                for i in range(2):
                    mass[k, row, i, (k + column) % m, i] += weight
        layer = self._tested[1].reshape(4 * m, m, 2, 2)
        double = layer[:, :, 0] + np.roll(layer[:, :, 1], 1, axis=1)
        return double.reshape(4 * m, 2 * m) + 0.5 * mass.reshape(4 * m, 2 * m)

    def evaluate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Representation formula ``u = V t - K u`` at points ``(n, 2)`` inside.

        Parameters
        ----------
        points : (n, 2) array

        Returns
        -------
        (2 n, 4 m) array, (2 n, 2 m) array
            V and -K.
        """
        single, double = self.layers(points)
        return single, -double

    def layers(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Single and double layer at points off the boundary.

        Parameters
        ----------
        points : (n, 2) array

        Returns
        -------
        (2 n, 4 m) array, (2 n, 2 m) array
        """
        n, m = points.shape[0], self.lengths.size
        kernel, stress = _moments(points, self.vertices, self._ends, self.lengths)
        constant = np.log(self.scale) / (8.0 * np.pi) * self.lengths
        kernel = kernel + constant[:, None, None, None] * np.eye(2)
        single = kernel.transpose(0, 3, 1, 2, 4).reshape(2 * n, 4 * m)
        double = stress[:, :, 0] + np.roll(stress[:, :, 1], 1, axis=1)
        return single, double.transpose(0, 2, 1, 3).reshape(2 * n, 2 * m)


def _moments(
    x: np.ndarray, a: np.ndarray, b: np.ndarray, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of both kernels against the linear functions of each segment.

    Returns two arrays ``(n, m, 2, 2, 2)``: point, segment, function, row and column.
    """
    t = (b - a) / length[:, None]
    normal = np.stack([t[:, 1], -t[:, 0]], axis=1)
    d = x[:, None] - a
    s = np.einsum("pmi,mi->pm", d, t)
    h = np.einsum("pmi,mi->pm", d, normal)
    h = np.where(np.abs(h) < TINY, 0.0, h)
    u1, u2 = -s, length - s
    r1, r2 = np.maximum(u1**2 + h**2, 1e-300), np.maximum(u2**2 + h**2, 1e-300)
    log1, log2 = np.log(r1), np.log(r2)
    j, q = 0.5 * (log2 - log1), 1.0 / r2 - 1.0 / r1
    uq = u2 / r2 - u1 / r1
    angle = np.where(h == 0.0, 0.0, np.arctan2(h * length, h**2 + u1 * u2))

    def linear(zeroth: np.ndarray, first: np.ndarray) -> np.ndarray:
        second = (first + s * zeroth) / length
        return np.stack([zeroth - second, second], axis=-1)

    log = linear(
        -0.5 * (u2 * log2 - u1 * log1 - 2.0 * length + 2.0 * h * angle),
        -0.25 * (r2 * (log2 - 1.0) - r1 * (log1 - 1.0)),
    )
    tt, tn = length - h * angle, -h * j
    dyad = (
        linear(tt, 0.5 * (u2**2 - u1**2) - h**2 * j),
        linear(tn, -h * tt),
        linear(h * angle, h**2 * j),
    )
    tt, tn = 0.5 * (angle - h * uq), 0.5 * h**2 * q
    stress = (
        linear(tt, h * (j + 0.5 * h**2 * q)),
        linear(tn, -h * tt),
        linear(0.5 * (angle + h * uq), -0.5 * h**3 * q),
    )
    kernel = _cartesian(dyad, t, normal) + log[..., None, None] * np.eye(2)
    return kernel / (4.0 * np.pi), _cartesian(stress, t, normal) / np.pi


def _cartesian(
    parts: tuple[np.ndarray, np.ndarray, np.ndarray], t: np.ndarray, n: np.ndarray
) -> np.ndarray:
    """Components tt, tn, nn as symmetric 2x2 matrices."""
    tn = np.einsum("mi,mk->mik", t, n)
    dyads = (
        np.einsum("mi,mk->mik", t, t),
        tn + tn.transpose(0, 2, 1),
        np.einsum("mi,mk->mik", n, n),
    )
    return sum(p[..., None, None] * d[:, None] for p, d in zip(parts, dyads, strict=True))
