"""The traction of a solved flow, and what follows from it: forces, torques, fluxes, the field."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..solvers.gmres import KrylovResult
from ..traction_error import TractionError
from .field import FlowField, flow_field
from .formulation import JumpFormulation

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class SurfaceTraction:
    """Traction jump across the surfaces of a `StokesFlow`.

    Parameters
    ----------
    coefficients : (n_dofs, 3) array
    zeta : (n_components,) array
        Multipliers: quadrature and Krylov error of the flux, a health indicator.
    result : KrylovResult
        How the linear solve ended, or that the velocity cannot be.
    iterations : int
        Of GMRES, 0 for a direct solve.
    residual : float
        True relative residual.
    error : TractionError
        Estimated shares of mesh, quadrature, compression and Krylov iteration.
    velocity : (n_points, 3) array
        Boundary velocity at the points.
    formulation : JumpFormulation
        The operators behind it.
    viscosity : float
        Of the fluid inside.
    background : callable or None
        Undisturbed velocity ``(n, 3) -> (n, 3)`` of the outer fluid.
    """

    coefficients: np.ndarray
    zeta: np.ndarray
    result: KrylovResult
    iterations: int
    residual: float
    error: TractionError
    velocity: np.ndarray
    formulation: JumpFormulation
    viscosity: float
    background: Callable[[np.ndarray], np.ndarray] | None

    @cached_property
    def values(self) -> np.ndarray:
        """Traction at the points of the flow, ``(n_points, 3)``."""
        return self.formulation.surface.basis @ self.coefficients

    def force(self) -> np.ndarray:
        """Force that each component exerts on the fluid.

        Returns
        -------
        (n_components, 3) array
        """
        return self._integrals(self.values)

    def torque(self, about: np.ndarray | None = None) -> np.ndarray:
        """Torque that each component exerts on the fluid.

        Parameters
        ----------
        about : (3,) array, optional
            Default: the origin.

        Returns
        -------
        (n_components, 3) array
        """
        points = self.formulation.surface.outer.points
        arm = points - (np.zeros(3) if about is None else np.asarray(about))
        return self._integrals(np.cross(arm, self.values))

    def flux(self) -> np.ndarray:
        """Flux of the boundary velocity out of each component.

        Returns
        -------
        (n_components,) array
        """
        through = np.sum(self.velocity * self.formulation.surface.outer.normals, axis=1)
        return self._integrals(through[:, None])[:, 0]

    def leak(self) -> np.ndarray:
        """Net flux of the boundary velocity over that of its size, ``int u . n / int |u|``.

        Returns
        -------
        (n_components,) array
        """
        size = self._integrals(np.linalg.norm(self.velocity, axis=1)[:, None])[:, 0]
        return self.flux() / np.where(size > 0.0, size, 1.0)

    def power(self) -> float:
        """Work of the surfaces on the fluid, ``<tau, u>``; the dissipation without background.

        Returns
        -------
        float
        """
        weights = self.formulation.surface.outer.weights
        return float(weights @ np.sum(self.values * self.velocity, axis=1))

    def field(self, points: np.ndarray) -> FlowField:
        """Velocity, pressure and stress at points inside and outside.

        Points on the surface get its velocity and NaN for the rest. Of a background flow the
        velocity is included; pressure and stress are those of the layers.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        FlowField

        Raises
        ------
        ValueError
            Points of the wrong shape or not finite.
        """
        made, viscosity = self.formulation, self.viscosity
        found = flow_field(
            made.surface,
            self.coefficients / viscosity,
            np.atleast_2d(points),
            velocity=made.project(made.surface.project(self.velocity)),
            viscosity_ratio=made.viscosity_ratio,
            background=self.background,
            orders=made.orders,
        )
        scaled = {"pressure": viscosity * found.pressure, "stress": viscosity * found.stress}
        return replace(found, **scaled)

    @cached_property
    def _components(self) -> np.ndarray:
        """Closed component of each point, ``(n_points,)``."""
        surface, components = self.formulation.surface, self.formulation.components
        first = surface.patches.dofs[surface.patches.indptr[:-1]]
        labels = np.zeros(first.size, int) if components is None else components[first]
        return np.repeat(labels, surface.outer.per_element)

    def _integrals(self, density: np.ndarray) -> np.ndarray:
        label, weights = self._components, self.formulation.surface.outer.weights
        sums = np.zeros((label.max() + 1, density.shape[1]))
        np.add.at(sums, label, weights[:, None] * density)
        return sums


def with_flux_judged(traction: SurfaceTraction, tolerance: float) -> SurfaceTraction:
    """The same, with the result ``NET_FLUX`` and a word in the log if a component leaks more."""
    leak = traction.leak()
    k = int(np.abs(leak).argmax())
    if np.abs(leak[k]) <= tolerance:
        return traction
    result = KrylovResult.NET_FLUX
    logger.warning(
        "component %d: %s (flux %.3g, %.1e of what |u| would carry)",
        k,
        result.value,
        traction.flux()[k],
        abs(leak[k]),
    )
    return replace(traction, result=result)
