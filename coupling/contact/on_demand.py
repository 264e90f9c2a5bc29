"""Contact that costs nothing while sheets are far: a bound on the motion tells how long.

Sheets a gap g apart cannot come within the reach r of the forces before points have moved by
``(g - r) / 2``. Until then there is no energy, no force and no test; then the gap is measured anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_matrix

from .barrier_contact import BarrierContact
from .sampled_mesh import SampledMesh


@dataclass
class OnDemand:
    """A contact around another one that is asked only where it can act.

    Parameters
    ----------
    contact : BarrierContact
    gap : callable
        Smallest gap of a configuration ``(n_full, 3)``.
    reach : float
        Distance from which on the contact acts.
    measured : int
        How often the gap was measured.
    asked : int
        How often the contact was needed.
    """

    contact: BarrierContact
    gap: Callable[[np.ndarray], float]
    reach: float
    measured: int = 0
    asked: int = 0
    _centre: np.ndarray | None = field(default=None, init=False, repr=False)
    _far: float = field(default=0.0, init=False, repr=False)
    _close: float = field(default=0.0, init=False, repr=False)

    @property
    def mesh(self) -> SampledMesh:
        """The sampled surface."""
        return self.contact.mesh

    def at(self, t: float) -> OnDemand:
        """Itself: nothing moves by prescription."""
        return self

    def near(self, *configurations: np.ndarray) -> bool:
        """Say whether sheets may come within reach on straight ways between configurations."""
        moved = self._moved(configurations)
        if moved < self._far:
            return False
        if moved >= self._close:
            self._centre = configurations[0].copy()
            free = 0.5 * (self.gap(self._centre) - self.reach)
            # where sheets are within reach already that holds for a while, too
            self._far, self._close = max(free, 0.0), max(-free, 0.25 * self.reach)
            self.measured += 1
            if self._moved(configurations) < self._far:
                return False
        self.asked += 1
        return True

    def _moved(self, configurations: tuple[np.ndarray, ...]) -> float:
        """Longest way of a coefficient from where the gap was measured."""
        if self._centre is None:
            return np.inf
        ways = [np.linalg.norm(c - self._centre, axis=1).max() for c in configurations]
        return float(max(ways))

    def energy(self, coefficients: np.ndarray) -> float:
        """Potential of the contact forces."""
        return self.contact.energy(coefficients) if self.near(coefficients) else 0.0

    def derivatives(self, coefficients: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """Gradient and tangent of the potential."""
        if self.near(coefficients):
            gradient, tangent = self.contact.derivatives(coefficients)
            return gradient, tangent
        return np.zeros(coefficients.size), csr_matrix(2 * (coefficients.size,))

    def free_step(self, start: np.ndarray, end: np.ndarray) -> float:
        """Fraction of the straight way on which nothing crosses."""
        return self.contact.free_step(start, end) if self.near(start, end) else 1.0

    def distance(self, coefficients: np.ndarray) -> float:
        """Smallest distance of what contact keeps apart; infinity where that is out of reach."""
        return self.contact.distance(coefficients) if self.near(coefficients) else np.inf

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """Sum ``(3,)`` of the contact forces on the structure."""
        return self.contact.force(coefficients) if self.near(coefficients) else np.zeros(3)

    def within_reach(self, coefficients: np.ndarray) -> int:
        """Number of samples that contact forces act on."""
        return self.contact.within_reach(coefficients) if self.near(coefficients) else 0

    def pressure(self, coefficients: np.ndarray) -> np.ndarray:
        """Contact pressure ``(n,)`` at the samples."""
        if self.near(coefficients):
            return self.contact.pressure(coefficients)
        return np.zeros(self.mesh.sample.shape[0])


Carrying: TypeAlias = BarrierContact | OnDemand
