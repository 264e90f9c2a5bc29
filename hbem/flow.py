"""Stokes flow about closed surfaces of given velocity: the library's front door.

``V tau = u``, ``<tau, n> = 0`` on each closed component: tau is the traction jump across the
surfaces, fluid of one viscosity on both sides [T 3.10a]. For rigid motions the fluid inside is at
rest in the body's frame and tau is the outer traction, up to a constant pressure.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .accuracy import Budget, budget
from .gap import narrowest
from .gmres import KrylovResult
from .krylov import DENSE_LIMIT, DenseSaddle, IterativeSaddle, MassPreconditioner, saddle
from .patches import BezierPatches, SurfacePatches
from .preconditioner import two_level_schwarz
from .quadrature import QuadratureOrders
from .sampling import SampledSurface, sample
from .single_layer import SingleLayer, single_layer
from .topology import closed_components

logger = logging.getLogger(__name__)
Velocity = Callable[[np.ndarray], np.ndarray] | np.ndarray


@dataclass(frozen=True)
class SurfaceTraction:
    """Traction of a flow.

    Attributes
    ----------
    flow : StokesFlow
    coefficients : (n_dofs, 3) array
    zeta : (n_components,) array
        Multipliers: quadrature and Krylov error of the flux, a health indicator.
    result : KrylovResult
    iterations : int
    residual : float
        True relative residual.
    velocity : (n_points, 3) array
        Boundary velocity at the points.
    """

    flow: StokesFlow
    coefficients: np.ndarray
    zeta: np.ndarray
    result: KrylovResult
    iterations: int
    residual: float
    velocity: np.ndarray

    @cached_property
    def values(self) -> np.ndarray:
        """Traction at the points of the flow, ``(n_points, 3)``."""
        return self.flow.surface.basis @ self.coefficients

    def _integrals(self, density: np.ndarray) -> np.ndarray:
        label, weights = self.flow.point_components, self.flow.weights
        sums = np.zeros((label.max() + 1, density.shape[1]))
        np.add.at(sums, label, weights[:, None] * density)
        return sums

    def force(self) -> np.ndarray:
        """Force that each component exerts on the fluid, ``(n_components, 3)``."""
        return self._integrals(self.values)

    def torque(self, about: np.ndarray | None = None) -> np.ndarray:
        """Torque on the fluid about a point (default: the origin), ``(n_components, 3)``."""
        arm = self.flow.points - (np.zeros(3) if about is None else np.asarray(about))
        return self._integrals(np.cross(arm, self.values))

    def flux(self) -> np.ndarray:
        """Flux of the boundary velocity out of each component, ``(n_components,)``."""
        through = np.sum(self.velocity * self.flow.normals, axis=1)
        return self._integrals(through[:, None])[:, 0]

    def power(self) -> float:
        """Rate of dissipation ``<tau, u>``."""
        return float(self.flow.weights @ np.sum(self.values * self.velocity, axis=1))


class StokesFlow:
    """Stokes flow on one configuration of closed surfaces.

    Parameters
    ----------
    patches : SurfacePatches
        One or several closed surfaces, normals ``x_s x x_t`` outward.
    coefficients : (n_coefficients, 3) array, optional
        Configuration; default that of the patches.
    tolerance : float
        Relative traction error allowed to quadrature and Krylov iteration, beside that of the
        mesh. A gap too thin for it gives a warning, in ``budget.warnings`` and the log.
    viscosity : float
    orders : QuadratureOrders, optional
        Overrides those that follow from the tolerance.

    Attributes
    ----------
    points, normals, weights : (n_points, 3), (n_points, 3), (n_points,) array
        Quadrature points, where velocities are wanted and tractions given.
    components : (n_dofs,) int array
        Closed component of each density function.
    budget : Budget

    Raises
    ------
    SurfaceError
        An open surface, mixed orientation or inward normals.
    ValueError
        A viscosity that is not positive, or coefficients of the wrong shape.
    """

    def __init__(
        self,
        patches: SurfacePatches,
        coefficients: np.ndarray | None = None,
        *,
        tolerance: float = 1e-3,
        viscosity: float = 1.0,
        orders: QuadratureOrders | None = None,
    ):
        if not viscosity > 0.0:
            raise ValueError(f"viscosity must be positive, got {viscosity:g}")
        if coefficients is None:
            coefficients = patches.coefficients if isinstance(patches, BezierPatches) else None
            if coefficients is None:
                raise ValueError("these patches carry no configuration: give coefficients")
        self.patches, self.coefficients, self.viscosity = patches, coefficients, viscosity
        self.components = closed_components(patches, coefficients)
        gap = narrowest(sample(patches, coefficients, QuadratureOrders()))
        self.budget: Budget = budget(tolerance, gap.distance, gap.extent)
        for warning in self.budget.warnings:
            logger.warning(warning)
        self.orders = self.budget.orders if orders is None else orders

    @cached_property
    def layer(self) -> SingleLayer:
        return single_layer(self.patches, self.coefficients, self.orders)

    @cached_property
    def surface(self) -> SampledSurface:
        """Points alone; the operator is built at the first solve."""
        return sample(self.patches, self.coefficients, self.orders)

    @cached_property
    def system(self) -> DenseSaddle | IterativeSaddle:
        schwarz = self.budget.preconditioner == "schwarz"
        return saddle(
            self.layer,
            self.surface.constraint,
            self.surface.mass,
            components=self.components,
            dense_limit=DENSE_LIMIT,
            tolerance=self.budget.krylov,
            preconditioner=two_level_schwarz if schwarz else MassPreconditioner,
        )

    @property
    def points(self) -> np.ndarray:
        return self.surface.outer.points

    @property
    def normals(self) -> np.ndarray:
        return self.surface.outer.normals

    @property
    def weights(self) -> np.ndarray:
        return self.surface.outer.weights

    @cached_property
    def point_components(self) -> np.ndarray:
        """Closed component of each point, ``(n_points,)``."""
        first = self.patches.dofs[self.patches.indptr[:-1]]
        return np.repeat(self.components[first], self.surface.outer.per_element)

    def traction(self, velocity: Velocity) -> SurfaceTraction:
        """Traction for a boundary velocity.

        Parameters
        ----------
        velocity : callable or (n_points, 3) array
            A callable receives points ``(n, 3)``; arrays belong to `points`. A net flux out of
            a component cannot be: the fluid is incompressible, the solution then leaks it.

        Raises
        ------
        ValueError
            A velocity of the wrong shape or not finite.
        """
        u = velocity(self.points) if callable(velocity) else velocity
        u = np.asarray(u, dtype=float)
        if u.shape == (3,):
            u = np.broadcast_to(u, self.points.shape)
        if u.shape != self.points.shape or not np.all(np.isfinite(u)):
            raise ValueError(f"expected finite velocities {self.points.shape}, got {u.shape}")
        found = self.system.solve(self.surface.project(u).ravel())
        if not found.result.ok:
            logger.warning("%s (residual %.1e)", found.result.value, found.residual)
        return SurfaceTraction(
            self,
            self.viscosity * found.solution.reshape(-1, 3),
            self.viscosity * np.atleast_1d(found.zeta),
            found.result,
            found.iterations,
            found.residual,
            u,
        )
