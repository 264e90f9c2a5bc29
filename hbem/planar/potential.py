"""Potential flow in a planar bag: ``phi/2 + K phi = V h`` and Bernoulli's pressure.

h is the normal velocity, phi continuous and linear with zero mean; the pressure
``p = -(h^2 + |D_Gamma phi|^2)/2`` up to a level, which the volume constraint sets [T 4.6, 4.11].
There is no d phi/dt: the flow has no inertia, its load is quadratic in the velocity.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.sparse import csr_matrix

from ..traction import Traction
from . import _planar_kernels as kernels
from .contact import ContactForce
from .polygon import Boundary, Configuration, OuterRule, edges, tested


def laplace_layers(
    points: np.ndarray, *, rule: OuterRule | None = None, log_radius: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Galerkin matrices V and K of a closed polygon, discontinuous linear functions.

    Parameters
    ----------
    points : (n, 2) array
        Counterclockwise.
    rule : OuterRule, optional
    log_radius : float
        s in the kernel log(s/r) of V.

    Returns
    -------
    V, K : (2 n, 2 n) array
        Dof ``2 e + m`` is function m on segment e.
    """
    points = np.ascontiguousarray(points, dtype=float)
    size = 2 * points.shape[0]
    V, K = np.zeros((size, size)), np.zeros((size, size))
    arrays = (rule or OuterRule()).arrays
    kernels.laplace_matrices(points, arrays, float(np.log(log_radius)), V, K)
    return V, K


class PotentialSystem:
    """Potential flow in one closed polygon: Neumann data to the potential and the pressure.

    Parameters
    ----------
    points : (n, 2) array
        Counterclockwise.
    rule : OuterRule, optional
    """

    def __init__(self, points: np.ndarray, *, rule: OuterRule | None = None):
        self.lengths, self.normals = edges(points)
        n = self.lengths.size
        nodes = (np.repeat(np.arange(n), 2) + np.tile([0, 1], n)) % n
        self.trace = csr_matrix((np.ones(2 * n), (np.arange(2 * n), nodes)), (2 * n, n))
        self.V, K = laplace_layers(points, rule=rule)
        nodal = self.trace.toarray()
        system = np.zeros((n + 1, n + 1))
        system[:n, :n] = self.trace.T @ (0.5 * tested(self.lengths, nodal) + K @ nodal)
        system[n, :n] = system[:n, n] = self.trace.T @ np.repeat(0.5 * self.lengths, 2)
        self._factors = scipy.linalg.lu_factor(system, check_finite=False)

    def solve(self, h: np.ndarray) -> tuple[np.ndarray, float]:
        """Solve for the potential of a normal velocity.

        Parameters
        ----------
        h : (2 n,) array
            Values at both ends of each segment.

        Returns
        -------
        phi : (n,) array
            At the nodes.
        zeta : float
            Multiplier of the mean of phi.
        """
        right = np.append(self.trace.T @ (self.V @ h), 0.0)
        solution = scipy.linalg.lu_solve(self._factors, right, check_finite=False)
        return solution[:-1], float(solution[-1])

    def pressure(self, h: np.ndarray, potential: np.ndarray) -> np.ndarray:
        """Bernoulli's pressure as discontinuous linear values [T 4.11].

        Parameters
        ----------
        h : (2 n,) array
        potential : (n,) array

        Returns
        -------
        (2 n,) array
        """
        slope = (np.roll(potential, -1) - potential) / self.lengths
        return -0.5 * (h**2 + np.repeat(slope, 2) ** 2)


@dataclass(frozen=True)
class PlanarPotential:
    """Potential flow in a planar bag, with an optional contact force; a `Fluid`.

    Its load is no linear map of the velocity: partitioned schemes only.

    Parameters
    ----------
    boundary : Boundary
    mass_ratio : float
        varpi.
    contact : ContactForce, optional
    rule : OuterRule

    Raises
    ------
    ValueError
        A mass ratio that is not positive.
    """

    boundary: Boundary
    mass_ratio: float
    contact: ContactForce | None = None
    rule: OuterRule = field(default_factory=OuterRule)

    def __post_init__(self) -> None:
        if not self.mass_ratio > 0.0:
            raise ValueError(f"mass_ratio must be positive, got {self.mass_ratio}")

    def assemble(self, coefficients: np.ndarray) -> PotentialOperator:
        """Assemble the flow on one configuration.

        Parameters
        ----------
        coefficients : (n_coefficients, 2) array

        Returns
        -------
        PotentialOperator
        """
        return PotentialOperator(self, self.boundary.at(coefficients))

    def reset(self) -> None:
        """Nothing is kept between geometries."""


@dataclass(frozen=True)
class PotentialOperator:
    """The flow on one frozen polygon; see `PlanarPotential`."""

    model: PlanarPotential
    at: Configuration

    @cached_property
    def _system(self) -> PotentialSystem:
        return PotentialSystem(self.at.points, rule=self.model.rule)

    def normal_velocity(self, nodal: np.ndarray) -> np.ndarray:
        """h as discontinuous linear values ``(2 n,)`` of nodal velocities ``(n, 2)``."""
        ends = self.model.boundary.trace @ nodal
        return np.einsum("ei,ei->e", ends, np.repeat(self.at.normals, 2, axis=0))

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of ``velocity (n_coefficients, 2)`` out through the membrane."""
        return self.at.flux(velocity)

    def traction(self, velocity: np.ndarray) -> Traction:
        """``-p n`` for a membrane velocity ``(n_coefficients, 2)``."""
        nodal = self.at.nodal_velocity(velocity)
        h = self.normal_velocity(nodal)
        potential, zeta = self._system.solve(h)
        tau = -self._system.pressure(h, potential)[:, None] * np.repeat(self.at.normals, 2, axis=0)
        largest = float(np.linalg.norm(nodal, axis=1).max())
        return Traction(tau, zeta, self.flux(velocity), largest)

    def load(self, traction: Traction) -> np.ndarray:
        """``varpi <p n, rho>`` and the contact force, ``(n_coefficients, 2)`` [T 4.13, 4.21]."""
        load = -self.model.mass_ratio * (self.at.testing @ traction.coefficients)
        if self.model.contact is not None:
            load = load + self.model.contact.load(self.at)
        return load

    def drive(self) -> None:
        """No background flow loads the membrane at rest."""

    def response(self) -> None:
        """Refused: Bernoulli's pressure is quadratic in the velocity.

        Raises
        ------
        TypeError
        """
        raise TypeError(
            "the load of potential flow is not linear in the velocity; use a partitioned scheme "
            "(coupling.scheme = 'gauss-seidel' or 'aitken')"
        )
