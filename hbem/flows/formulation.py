"""Boundary integral formulations of Stokes flow, ``V tau = F``: data, system and solution.

With n outward, ``lambda`` exterior over interior viscosity, tractions in units of the interior
viscosity and ``tau_j = tau_i - tau_e``:

    interior  V tau_i = u/2 + K u                                   [T 3.8], lambda = 0
    exterior  V tau_e = -u/2 + K u + u_inf                          [T 5.3], outer viscosity
    jump      V tau_j = (1 + lambda)/2 u + (1 - lambda) K u - lambda u_inf     [T 5.4]

The double layer K is needed only for ``lambda != 1``; ``<tau, n> = 0`` on each closed component.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, SuperLU, splu

from ..layers.compressed_layer import CompressedSingleLayer
from ..layers.double_layer import DoubleLayer, double_layer
from ..layers.layer import SingleLayer
from ..solvers.saddle import DENSE_LIMIT, DenseSaddle, IterativeSaddle, saddle
from ..solvers.saddle_system import Builder
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface


def needs_double_layer(viscosity_ratio: float) -> bool:
    """Whether the double layer enters at this viscosity ratio (remark 35 of the thesis)."""
    return viscosity_ratio != 1.0


def jump_data(
    velocity: np.ndarray,
    viscosity_ratio: float,
    double: LinearOperator | np.ndarray | None,
    projected: np.ndarray | None = None,
    background: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Right-hand side for the traction jump [T 5.4].

    Parameters
    ----------
    velocity : (3 n_dofs,) or (3 n_dofs, k) array
        Tested boundary velocity ``<u, N_a>``.
    viscosity_ratio : float
        ``lambda``, exterior over interior; 0 is the interior problem.
    double : LinearOperator, (3 n_dofs, 3 n_dofs) array or None
        The double layer; not used for ``lambda = 1``.
    projected : array, optional
        Coefficients of u in the density space, ``M^-1`` times the tested velocity.
    background : array or float
        Tested velocity at infinity.

    Returns
    -------
    array of the shape of ``velocity``

    Raises
    ------
    ValueError
        A negative ratio, or a missing double layer.
    """
    ratio = viscosity_ratio
    if not (np.isfinite(ratio) and ratio >= 0.0):
        raise ValueError(f"viscosity ratio must be finite and not negative, got {ratio}")
    data = 0.5 * (1.0 + ratio) * velocity - ratio * background
    if needs_double_layer(ratio):
        if double is None or projected is None:
            raise ValueError(f"viscosity ratio {ratio} needs the double layer")
        data = data + (1.0 - ratio) * (double @ projected)
    return data


def exterior_data(
    velocity: np.ndarray,
    double: LinearOperator,
    projected: np.ndarray,
    background: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Right-hand side for the exterior traction, per outer viscosity [T 5.3]."""
    return -0.5 * velocity + double @ projected + background


@dataclass(frozen=True)
class JumpFormulation:
    """The traction jump of [T 5.4] on one configuration.

    Parameters
    ----------
    layer : SingleLayer
        V; a compressed one is solved by GMRES at any size.
    viscosity_ratio : float
        ``lambda``.
    orders : QuadratureOrders
        Of the double layer, those of the single one.
    tolerance : float
        True relative residual of GMRES.
    preconditioner : callable
        Of GMRES, built from a `SaddleSystem`.
    max_iterations : int
    dense_limit : int
        Unknowns up to which the system is solved by LU.
    components : (n_dofs,) int array, optional
        Closed component of each density function; default one.
    """

    layer: SingleLayer
    viscosity_ratio: float
    orders: QuadratureOrders
    tolerance: float
    preconditioner: Builder
    max_iterations: int = 400
    dense_limit: int = DENSE_LIMIT
    components: np.ndarray | None = None

    @property
    def surface(self) -> SampledSurface:
        return self.layer.surface

    @cached_property
    def double(self) -> DoubleLayer | None:
        """K; None for equal viscosities."""
        if not needs_double_layer(self.viscosity_ratio):
            return None
        return double_layer(self.surface, self.orders)

    @cached_property
    def system(self) -> DenseSaddle | IterativeSaddle:
        """The saddle system of V and the constraints."""
        compressed = isinstance(self.layer, CompressedSingleLayer)
        return saddle(
            self.layer,
            self.surface.constraint,
            self.surface.mass,
            components=self.components,
            dense_limit=0 if compressed else self.dense_limit,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            preconditioner=self.preconditioner,
        )

    @cached_property
    def _mass_factor(self) -> SuperLU:
        return splu(self.surface.mass.tocsc())

    def project(self, tested: np.ndarray) -> np.ndarray:
        """Coefficients of the density with the integrals ``tested (n_dofs, k)``: same shape."""
        return self._mass_factor.solve(tested)

    def data(self, tested: np.ndarray, background: np.ndarray | float = 0.0) -> np.ndarray:
        """Right-hand side for tested velocities, see `jump_data`: ``(3 n_dofs,)`` or with k."""
        double: LinearOperator | np.ndarray | None = self.double
        projected = None
        if self.double is not None:
            projected = self.project(tested.reshape(self.surface.patches.n_dofs, -1))
            projected = projected.reshape(tested.shape)
            double = self.double if tested.ndim == 1 else self.double.dense()
        return jump_data(tested, self.viscosity_ratio, double, projected, background)
