"""Planar Stokes flow inside and outside a membrane, for every viscosity ratio lambda.

``V tau = (1 + lambda)/2 u + (1 - lambda) K u, <tau, n> = 0`` [T 5.4, 5.5]; lambda = 0 is the
interior alone. V has the kernel log(s/r): for lambda = 0 the traction does not depend on s, which
keeps V definite at any size; for lambda > 0 no flow vanishes at infinity (Stokes' paradox), and s
is the radius where it is taken to vanish: a parameter of the physics.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.sparse.linalg import LinearOperator

from ..traction import Traction
from . import _planar_kernels as kernels
from .polygon import Boundary, Configuration, OuterRule, edges, tested

LOG_RADIUS = 100.0


def stokes_layers(
    points: np.ndarray,
    *,
    rule: OuterRule | None = None,
    double: bool = True,
    log_radius: float = 1.0,
) -> tuple[np.ndarray, np.ndarray | None]:
    """Galerkin matrices V and K of a closed polygon, discontinuous linear functions, Re = 1.

    Parameters
    ----------
    points : (n, 2) array
        Counterclockwise.
    rule : OuterRule, optional
    double : bool
        Also K; otherwise None in its place.
    log_radius : float
        s in log(s/r).

    Returns
    -------
    V, K : (4 n, 4 n) array
        Dof ``4 e + 2 m + i``: component i of function m on segment e.
    """
    points = np.ascontiguousarray(points, dtype=float)
    size = 4 * points.shape[0]
    V = np.zeros((size, size))
    K = np.zeros((size, size)) if double else np.zeros((1, 1))
    arrays = (rule or OuterRule()).arrays
    kernels.stokes_matrices(points, arrays, double, float(np.log(log_radius)), V, K)
    return V, K if double else None


class StokesSystem:
    """The flow around one closed polygon: boundary velocities to traction jumps [T 5.5].

    Parameters
    ----------
    points : (n, 2) array
        Counterclockwise.
    viscosity_ratio, log_radius, rule
        See `PlanarStokes`.
    """

    def __init__(
        self,
        points: np.ndarray,
        *,
        viscosity_ratio: float = 0.0,
        log_radius: float = LOG_RADIUS,
        rule: OuterRule | None = None,
    ):
        self.lengths, self.normals = edges(points)
        self.ratio = viscosity_ratio
        double = viscosity_ratio != 1.0
        V, self.K = stokes_layers(points, rule=rule, double=double, log_radius=log_radius)
        n = V.shape[0]
        system = np.zeros((n + 1, n + 1))
        system[:n, :n] = V
        normal = 0.5 * self.lengths[:, None, None] * self.normals[:, None]
        system[n, :n] = np.broadcast_to(normal, (n // 4, 2, 2)).ravel()
        system[:n, n] = system[n, :n]
        self._factors = scipy.linalg.lu_factor(system, overwrite_a=True, check_finite=False)

    def solve(self, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions and multipliers of ``<tau, n> = 0``.

        Parameters
        ----------
        velocity : (4 n, k) array
            Values at both ends of each segment, dof ``4 e + 2 m + i``.

        Returns
        -------
        tau : (4 n, k) array
        zeta : (k,) array
        """
        shape = velocity.shape
        data = 0.5 * (1.0 + self.ratio) * tested(self.lengths, velocity.reshape(-1, 2 * shape[1]))
        data = data.reshape(shape)
        if self.K is not None:
            data += (1.0 - self.ratio) * (self.K @ velocity)
        right = np.concatenate([data, np.zeros((1, shape[1]))])
        solution = scipy.linalg.lu_solve(self._factors, right, check_finite=False)
        return solution[:-1], solution[-1]


@dataclass(frozen=True)
class PlanarStokes:
    """Stokes flow in and around a planar bag; a `coupling.protocols.Fluid`.

    Parameters
    ----------
    boundary : Boundary
    mass_ratio : float
        ``m = varpi / Re``.
    viscosity_ratio : float
        lambda, exterior over interior viscosity; 0 leaves the exterior out.
    log_radius : float
        s in log(s/r), larger than the bag.
    rule : OuterRule

    Raises
    ------
    ValueError
        A mass ratio or radius that is not positive, a negative viscosity ratio.
    """

    boundary: Boundary
    mass_ratio: float
    viscosity_ratio: float = 1.0
    log_radius: float = LOG_RADIUS
    rule: OuterRule = field(default_factory=OuterRule)

    def __post_init__(self) -> None:
        if not (self.mass_ratio > 0.0 and self.log_radius > 0.0):
            raise ValueError("mass_ratio and log_radius must be positive")
        if not self.viscosity_ratio >= 0.0:
            raise ValueError(f"viscosity_ratio must not be negative, got {self.viscosity_ratio}")

    def assemble(self, coefficients: np.ndarray) -> StokesOperator:
        """Assemble the flow on one configuration.

        Parameters
        ----------
        coefficients : (n_coefficients, 2) array

        Returns
        -------
        StokesOperator
        """
        return StokesOperator(self, self.boundary.at(coefficients))

    def reset(self) -> None:
        """Nothing is kept between geometries."""


@dataclass(frozen=True)
class StokesOperator:
    """The flow on one frozen polygon; see `PlanarStokes`."""

    model: PlanarStokes
    at: Configuration

    @cached_property
    def _system(self) -> StokesSystem:
        m = self.model
        return StokesSystem(
            self.at.points,
            viscosity_ratio=m.viscosity_ratio,
            log_radius=m.log_radius,
            rule=m.rule,
        )

    def solve(self, nodal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions ``(4 n, k)`` and zetas ``(k,)`` of nodal velocities ``(2 n, k)``."""
        return self._system.solve(self.model.boundary.vector_trace @ nodal)

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of ``velocity (n_coefficients, 2)`` out through the membrane."""
        return self.at.flux(velocity)

    def traction(self, velocity: np.ndarray) -> Traction:
        """Traction jump for a membrane velocity ``(n_coefficients, 2)``."""
        nodal = self.at.nodal_velocity(velocity)
        tau, zeta = self.solve(nodal.reshape(-1, 1))
        largest = float(np.linalg.norm(nodal, axis=1).max())
        return Traction(tau.reshape(-1, 2), float(zeta[0]), self.flux(velocity), largest)

    def load(self, traction: Traction) -> np.ndarray:
        """Force ``-m <tau, rho>`` on the membrane, ``(n_coefficients, 2)`` [T 5.10c]."""
        return -self.model.mass_ratio * (self.at.testing @ traction.coefficients)

    def drive(self) -> None:
        """No background flow loads the membrane at rest."""

    def response(self) -> PlanarResponse:
        """Velocity to load, ``2 n_coefficients`` square."""
        return PlanarResponse(self)


class PlanarResponse(LinearOperator):
    """The linear map ``load = R v`` on interleaved coefficients ``2 a + i``."""

    def __init__(self, operator: StokesOperator):
        n = 2 * operator.model.boundary.n_coefficients
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self._operator = operator

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        op = self._operator
        return op.load(op.traction(np.asarray(x).reshape(-1, 2))).ravel()

    def dense(self) -> np.ndarray:
        """R as an array: only the nodes' velocities matter, slopes have zero columns."""
        op = self._operator
        n = self.shape[0]
        tau, _ = op.solve(op.at.nodal_matrix)
        loads = op.at.testing @ tau.reshape(tau.shape[0] // 2, -1)
        matrix = np.zeros((n, n // 4, 2, 2))
        matrix[:, :, 0] = -op.model.mass_ratio * loads.reshape(n, n // 4, 2)
        return matrix.reshape(n, n)
