"""Stokes flow about closed surfaces of given velocity: the library's front door.

``V tau = (1 + lambda)/2 u + (1 - lambda) K u - lambda u_inf`` [T 5.4], ``<tau, n> = 0`` on each
closed component: tau is the traction jump across the surfaces, lambda the outer over the inner
viscosity, u_inf the undisturbed outer flow. For lambda = 1 this is ``V tau = u - u_inf``, without
K. For rigid motions the fluid inside is at rest in the body's frame and tau is the outer traction,
up to a constant pressure.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import splu

from ..accuracy import Budget, budget
from ..layers.double_layer import DoubleLayer, double_layer
from ..layers.layer import SingleLayer
from ..layers.single_layer import single_layer
from ..solvers.gmres import KrylovResult
from ..solvers.saddle import DENSE_LIMIT, DenseSaddle, IterativeSaddle, MassPreconditioner, saddle
from ..solvers.schwarz import two_level_schwarz
from ..surfaces.narrowest_gap import narrowest
from ..surfaces.patches import BezierPatches, SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface, sample
from ..surfaces.topology import closed_components
from .field import FlowField, flow_field
from .formulation import jump_data, needs_double_layer

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
        """Work of the surfaces on the fluid ``<tau, u>``; the dissipation without background."""
        return float(self.flow.weights @ np.sum(self.values * self.velocity, axis=1))

    def field(self, points: np.ndarray) -> FlowField:
        """Velocity, pressure and stress at points ``(n, 3)`` inside and outside.

        Points on the surface get its velocity and NaN for the rest. Of a background flow the
        velocity is included; pressure and stress are those of the layers.
        """
        flow, viscosity = self.flow, self.flow.viscosity
        found = flow_field(
            flow.surface,
            self.coefficients / viscosity,
            np.atleast_2d(np.asarray(points, dtype=float)),
            velocity=flow.coefficients_of(self.velocity),
            viscosity_ratio=flow.viscosity_ratio,
            background=None if flow.background is None else flow.undisturbed,
            orders=flow.orders,
        )
        scaled = {"pressure": viscosity * found.pressure, "stress": viscosity * found.stress}
        return replace(found, **scaled)


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
        Of the fluid inside.
    viscosity_ratio : float
        Outer over inner viscosity: 0 is the flow inside alone, without an outer fluid.
    background : callable or (3,) array, optional
        Undisturbed velocity of the outer fluid at points ``(n, 3)``; itself a Stokes flow.
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
        A viscosity that is not positive, a negative ratio, a background without outer fluid, or
        coefficients of the wrong shape.
    """

    def __init__(
        self,
        patches: SurfacePatches,
        coefficients: np.ndarray | None = None,
        *,
        tolerance: float = 1e-3,
        viscosity: float = 1.0,
        viscosity_ratio: float = 1.0,
        background: Velocity | None = None,
        orders: QuadratureOrders | None = None,
    ):
        _check(viscosity, viscosity_ratio, background)
        self.viscosity_ratio, self.background = viscosity_ratio, background
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
    def double(self) -> DoubleLayer:
        """Assembled only where the viscosities differ."""
        return double_layer(self.layer.surface, self.orders)

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
        u = _at(velocity, self.points)
        found = self.system.solve(self._data(u))
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

    def undisturbed(self, points: np.ndarray) -> np.ndarray:
        """Background velocity at points ``(n, 3)``."""
        return np.zeros(points.shape) if self.background is None else _at(self.background, points)

    def coefficients_of(self, values: np.ndarray) -> np.ndarray:
        """Coefficients ``(n_dofs, 3)`` of the density closest to point values, in L2."""
        return self._mass_factor.solve(self.surface.project(values))

    @cached_property
    def _mass_factor(self):
        return splu(self.surface.mass.tocsc())

    def _data(self, u: np.ndarray) -> np.ndarray:
        """Right-hand side for the velocity u at the points, ``(3 n_dofs,)``."""
        project = self.surface.project
        double, projected = None, None
        if needs_double_layer(self.viscosity_ratio):
            double, projected = self.double, self.coefficients_of(u).ravel()
        background = 0.0 if self.background is None else project(self.undisturbed(self.points))
        return jump_data(
            project(u).ravel(), self.viscosity_ratio, double, projected, np.ravel(background)
        )


def _check(viscosity: float, ratio: float, background: Velocity | None) -> None:
    if not viscosity > 0.0:
        raise ValueError(f"viscosity must be positive, got {viscosity:g}")
    if not (np.isfinite(ratio) and ratio >= 0.0):
        raise ValueError(
            f"viscosity_ratio must be finite and not negative, got {ratio:g}; it is outer over "
            "inner viscosity"
        )
    if background is not None and ratio == 0.0:
        raise ValueError(
            "viscosity_ratio = 0 has no outer fluid that a background could move: leave the "
            "background out, or give a positive ratio"
        )
    if background is not None and not callable(background) and np.shape(background) != (3,):
        raise ValueError(
            f"background: expected a callable or 3 numbers, got shape {np.shape(background)}"
        )


def _at(velocity: Velocity, points: np.ndarray) -> np.ndarray:
    """Checked velocities at points."""
    u = np.asarray(velocity(points) if callable(velocity) else velocity, dtype=float)
    if u.shape == (3,):
        u = np.broadcast_to(u, points.shape)
    if u.shape != points.shape or not np.all(np.isfinite(u)):
        raise ValueError(f"expected finite velocities {points.shape}, got {u.shape}")
    return u
