"""Soft contact force, recycled from the double-layer kernel [T 4.14-4.20].

``phi(x) = z int b(r/l) |(x-y).(n(x)-n(y))| (x-y)/r^3 ds(y)``: repulsive, reciprocal, zero between
neighbours on a straight line, cut off at l. It is no barrier: two parallel walls at distance
d -> 0 repel each other by ``z int 2 d^2 (d^2 + s^2)^(-3/2) ds = 4 z``, a bounded pressure, so that
a stronger load closes the gap (condition C4 of [T 4.1.4] does not hold for the integral).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import _planar_kernels as kernels
from .polygon import Configuration, _cubics, gauss


@dataclass(frozen=True)
class ContactForce:
    """Contact force of magnitude z and cut-off radius l.

    Parameters
    ----------
    magnitude, cutoff : float
    points : int
        Gauss points per segment, outer and inner.

    Raises
    ------
    ValueError
        Values that are not positive.
    """

    magnitude: float
    cutoff: float
    points: int = 4

    def __post_init__(self) -> None:
        if not (self.magnitude > 0.0 and self.cutoff > 0.0):
            raise ValueError("magnitude and cutoff of a contact force must be positive")

    @property
    def bound(self) -> float:
        """Limit of the repulsive pressure between parallel walls as their gap closes: 4 z."""
        return 4.0 * self.magnitude

    def tractions(self, points: np.ndarray) -> np.ndarray:
        """The traction phi at the Gauss points of a closed polygon.

        Parameters
        ----------
        points : (n, 2) array
            Nodes in order.

        Returns
        -------
        (n, n_gauss, 2) array
        """
        x, w = gauss(self.points)
        force = np.zeros((points.shape[0], self.points, 2))
        kernels.contact_tractions(np.ascontiguousarray(points), x, w, self.cutoff, force)
        return self.magnitude * force

    def load(self, at: Configuration) -> np.ndarray:
        """Force on the membrane tested with its functions [T 4.21].

        Parameters
        ----------
        at : Configuration

        Returns
        -------
        (n_coefficients, 2) array
        """
        b = at.boundary
        n, h = b.n_membrane, np.diff(b.arc_lengths)
        x, w = gauss(self.points)
        table = np.broadcast_to(_cubics(x), (n, x.size, 4)).copy()
        table[:, :, 1::2] *= h[:, None, None]
        force = self.tractions(at.points)[:n] * (at.lengths[:n, None] * w)[..., None]
        local = np.einsum("eqa,eqc->eac", table, force)
        load = np.zeros((b.n_coefficients, 2))
        rows = 2 * np.arange(n)[:, None] + np.arange(4)
        np.add.at(load, rows, local)
        return load
