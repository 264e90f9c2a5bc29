"""The flow of `enclosed_flow` on one frozen configuration: tractions, loads, response."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import aslinearoperator, splu

from ..layers.double_layer import DoubleLayer, double_layer
from ..layers.layer import SingleLayer
from ..response import Response
from ..solvers.saddle import DenseSaddle, IterativeSaddle, SaddleSolution, saddle
from ..surfaces.surface_points import SampledSurface, geometry_matrix
from ..traction import Traction
from .formulation import jump_data, needs_double_layer

if TYPE_CHECKING:
    from .enclosed_flow import EnclosedStokes


@dataclass(frozen=True)
class EnclosedOperator:
    """The flow on one frozen configuration; see `EnclosedStokes`.

    Attributes
    ----------
    model : EnclosedStokes
    layer : SingleLayer
    """

    model: EnclosedStokes
    layer: SingleLayer

    @property
    def surface(self) -> SampledSurface:
        return self.layer.surface

    @cached_property
    def system(self) -> DenseSaddle | IterativeSaddle:
        m = self.model
        return saddle(
            self.layer,
            self.surface.constraint,
            self.surface.mass,
            dense_limit=m.dense_limit if m.compression is None else 0,
            tolerance=m.tolerance,
            max_iterations=m.max_iterations,
            preconditioner=m.store,
        )

    @cached_property
    def _on_patch(self) -> np.ndarray:
        return np.repeat(self.model.inflow, self.surface.outer.per_element)

    @cached_property
    def evaluation(self) -> csr_matrix:
        """Psi: coefficients to values at outer points, zero on the inflow patch."""
        full = geometry_matrix(self.model.patches, self.surface.outer)
        return (diags(1.0 - self._on_patch) @ full).tocsr()

    @cached_property
    def coupling(self) -> csr_matrix:
        """``B^T W Psi``: coefficients to tested values, scalar ``(n_dofs, n_coefficients)``."""
        outer = self.surface.outer
        return (self.surface.basis.T @ diags(outer.weights) @ self.evaluation).tocsr()

    @cached_property
    def flux_form(self) -> np.ndarray:
        """The flux as a linear form of the velocity, ``(n_coefficients, 3)``."""
        outer = self.surface.outer
        return self.evaluation.T @ (outer.weights[:, None] * outer.normals)

    @cached_property
    def _unit_influx(self) -> np.ndarray:
        """Data on the patch for unit influx, at the outer points ``(n_points, 3)``."""
        outer, inside = self.surface.outer, self._on_patch
        values = np.zeros_like(outer.points)
        if self.model.profile is None:
            return values
        profile = np.asarray(self.model.profile(outer.points[inside]), dtype=float)
        total = outer.weights[inside] @ profile
        if not total > 0.0:
            raise ValueError(f"the inflow profile integrates to {total:.3g}, expected > 0")
        values[inside] = -profile[:, None] * outer.normals[inside] / total
        return values

    @cached_property
    def influx_data(self) -> np.ndarray:
        return self.surface.project(self._unit_influx)

    @cached_property
    def double(self) -> DoubleLayer | None:
        """The double layer; None for equal viscosities."""
        if not needs_double_layer(self.model.viscosity_ratio):
            return None
        return double_layer(self.surface, self.model.orders)

    @cached_property
    def _mass_factor(self):
        return splu(self.surface.mass.tocsc())

    def right_hand_side(self, tested: np.ndarray) -> np.ndarray:
        """Data of the traction jump from tested velocities ``(3 n_dofs,)`` or ``(3 n_dofs, k)``."""
        if self.double is None:
            return tested
        projected = self._mass_factor.solve(tested.reshape(self.surface.mass.shape[0], -1))
        double = self.double if tested.ndim == 1 else aslinearoperator(self.double.dense())
        ratio = self.model.viscosity_ratio
        return jump_data(tested, ratio, double, projected.reshape(tested.shape))

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of ``velocity (n_coefficients, 3)`` out through the membrane."""
        return float(np.sum(self.flux_form * velocity))

    def boundary_velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Dirichlet data at the outer points, ``(n_points, 3)``."""
        return self.evaluation @ velocity + self.flux(velocity) * self._unit_influx

    def traction(self, velocity: np.ndarray) -> Traction:
        """Traction jump for membrane velocity ``(n_coefficients, 3)``.

        Raises
        ------
        ValueError
            A velocity of the wrong shape.
        """
        expected = (self.model.patches.n_coefficients, 3)
        if np.shape(velocity) != expected:
            raise ValueError(f"expected velocity {expected}, got {np.shape(velocity)}")
        solved = self.solve(self.linear_data(velocity) - self._background_data)
        return Traction(
            solved.solution.reshape(-1, 3),
            float(solved.zeta),
            self.flux(velocity),
            float(np.linalg.norm(self.boundary_velocity(velocity), axis=1).max()),
            iterations=solved.iterations,
            residual=solved.residual,
        )

    def linear_data(self, velocity: np.ndarray) -> np.ndarray:
        """Right-hand side without background, ``(3 n_dofs,)``."""
        data = self.coupling @ velocity + self.flux(velocity) * self.influx_data
        return self.right_hand_side(data.ravel())

    @cached_property
    def _background_data(self) -> np.ndarray | float:
        """Tested ``lambda u_inf``."""
        m = self.model
        if m.background is None:
            return 0.0
        velocity = np.asarray(m.background(self.surface.outer.points), dtype=float)
        return m.viscosity_ratio * self.surface.project(velocity).ravel()

    def solve(self, data: np.ndarray) -> SaddleSolution:
        """Traction jump for a right-hand side ``(3 n_dofs,)``."""
        solved = self.system.solve(data)
        if solved.iterations:
            self.model.store.note(solved.iterations)
        if "_measured" not in self.__dict__:  # once for each geometry
            self.__dict__["_measured"] = True
            self.model.note(self.layer, solved.solution.reshape(-1, 3))
        return solved

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """``-m <tau, rho>`` of a traction's coefficients ``(n_dofs, 3)``."""
        return -self.model.mass_ratio * (self.coupling.T @ coefficients)

    def load(self, traction: Traction) -> np.ndarray:
        """Force ``-m <tau, rho>`` on the membrane, ``(n_coefficients, 3)``."""
        return self.force(traction.coefficients)

    def drive(self) -> np.ndarray | None:
        """Load of the background on the membrane at rest; None without background."""
        if self.model.background is None:
            return None
        return self.force(self.solve(-self._background_data).solution.reshape(-1, 3))

    def response(self) -> Response:
        """Velocity to load, ``3 n_coefficients`` square."""
        return Response(self)
