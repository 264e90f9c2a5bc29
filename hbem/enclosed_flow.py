"""Stokes flow inside and outside a membrane, inflated through a patch or closed in a background.

``V tau = (1 + lambda) / 2 u + (1 - lambda) K u - lambda u_inf``, ``<tau, n> = 0`` on the closed
surface [T 5.4]; equal viscosities leave out the double layer K. On a patch the data are
``u = -(phi(v) / int X) X n`` with the discrete flux ``phi(v)`` of the membrane velocity, so the
total discrete flux vanishes and all but the background is linear in v:
``R v = -m Psi^T W B S^-1 B^T W (Psi + patch) v`` (lambda = 1), m = varpi / Re.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import aslinearoperator, splu

from .compression import Compression
from .double_layer import DoubleLayer, double_layer
from .krylov import (
    DENSE_LIMIT,
    DenseSaddle,
    IterativeSaddle,
    MassPreconditioner,
    PreconditionerStore,
    SaddleSolution,
    saddle,
)
from .patches import SurfacePatches
from .preconditioner import two_level_schwarz
from .quadrature import QuadratureOrders
from .response import Response
from .sampling import SampledSurface, geometry_matrix
from .single_layer import SingleLayer, single_layer
from .stokes import jump_data, needs_double_layer

Profile = Callable[[np.ndarray], np.ndarray]
Velocity = Callable[[np.ndarray], np.ndarray]
BUILDERS = {"schwarz": two_level_schwarz, "mass": MassPreconditioner}


@dataclass(frozen=True)
class Traction:
    """Fluid traction jump on one geometry.

    Attributes
    ----------
    coefficients : (n_dofs, 3) array
        Coefficients in the density space, per unit ``1/Re``.
    zeta : float
        Multiplier of ``<tau, n> = 0``.
    flux : float
        Discrete flux of the membrane velocity, which the influx follows.
    velocity_max : float
        Largest velocity on the boundary, patch included.
    iterations : int
        Krylov iterations, 0 for a direct solve.
    residual : float
        True relative residual of the linear system.
    """

    coefficients: np.ndarray
    zeta: float
    flux: float = 0.0
    velocity_max: float = 0.0
    iterations: int = 0
    residual: float = 0.0


@dataclass(frozen=True)
class EnclosedStokes:
    """Stokes flow in and around a bag or a capsule.

    Parameters
    ----------
    patches : SurfacePatches
        Membrane and inflow patch, closed together, normals outward.
    inflow : (n_elements,) bool array
        Elements of the inflow patch; none of a closed membrane.
    profile : callable or None
        Inflow profile X on points ``(n, 3)``: ``(n,)``; the flow enters along the inward normal.
        None exactly if there is no patch.
    mass_ratio : float
        ``m = varpi / Re`` of the fluid inside.
    viscosity_ratio : float
        Exterior over interior viscosity; other than 1 it needs the double layer.
    background : callable, optional
        Undisturbed velocity u_inf of the outer fluid at points ``(n, 3)``, itself a Stokes flow.
    orders : QuadratureOrders
    dense_limit : int
        Unknowns up to which the system is solved by LU.
    tolerance : float
        Relative residual of GMRES.
    max_iterations : int
    storage : {"auto", "dense", "direct"}
        Of the single layer; see `hbem.single_layer.single_layer`.
    preconditioner : {"schwarz", "mass"}
        Of GMRES: two levels for gaps, the mass matrix for fat bodies. It is kept from one
        geometry to the next until it degrades or `reset` drops it.
    compression : Compression, optional
        Compress the single layer; it is then solved by GMRES at any size.

    Raises
    ------
    ValueError
        A negative viscosity ratio, a mass ratio that is not positive, an inflow array that does
        not fit or leaves no membrane, a patch without profile, a profile without patch, or a
        background without outer fluid.
    """

    patches: SurfacePatches
    inflow: np.ndarray
    profile: Profile | None
    mass_ratio: float
    viscosity_ratio: float = 1.0
    orders: QuadratureOrders = field(default_factory=QuadratureOrders)
    dense_limit: int = DENSE_LIMIT
    tolerance: float = 1e-8
    max_iterations: int = 400
    storage: str = "auto"
    preconditioner: str = "schwarz"
    compression: Compression | None = None
    background: Velocity | None = None

    def __post_init__(self) -> None:
        inflow = np.asarray(self.inflow, dtype=bool)
        object.__setattr__(self, "inflow", inflow)
        if not (np.isfinite(self.viscosity_ratio) and self.viscosity_ratio >= 0.0):
            raise ValueError(
                f"viscosity_ratio must be finite and not negative, got {self.viscosity_ratio}"
            )
        if not self.mass_ratio > 0.0:
            raise ValueError(f"mass_ratio must be positive, got {self.mass_ratio}")
        if inflow.shape != (self.patches.n_elements,):
            raise ValueError(
                f"inflow must mark {self.patches.n_elements} elements, got shape {inflow.shape}"
            )
        if inflow.all():
            raise ValueError("inflow must leave some elements to the membrane")
        if inflow.any() != (self.profile is not None):
            raise ValueError(
                "an inflow patch needs a profile, a membrane without patch takes profile = None"
            )
        if self.background is not None and self.viscosity_ratio == 0.0:
            raise ValueError("a background needs an outer fluid: viscosity_ratio above 0")
        if self.preconditioner not in BUILDERS:
            raise ValueError(
                f"preconditioner must be 'schwarz' or 'mass', got {self.preconditioner!r}"
            )

    @cached_property
    def store(self) -> PreconditionerStore:
        """The preconditioner in use."""
        return PreconditionerStore(BUILDERS[self.preconditioner])

    @cached_property
    def statistics(self) -> dict[str, float | int | str]:
        """Figures of the latest compressed operator, and the worst errors so far."""
        return {}

    def _note(self, layer: SingleLayer) -> None:
        if self.compression is None:
            return
        worst = {
            f"worst_{name}": max(value, self.statistics.get(f"worst_{name}", 0.0))
            for name in ("achieved", "error_gap")
            if (value := layer.statistics()[name]) == value
        }
        self.statistics.update(layer.statistics() | worst)

    def reset(self) -> None:
        """Forget what is kept between geometries; runs do so at checkpoints."""
        self.store.drop()

    def assemble(self, coefficients: np.ndarray) -> EnclosedOperator:
        """The flow on one configuration ``(n_coefficients, 3)``."""
        layer = single_layer(
            self.patches,
            coefficients,
            self.orders,
            storage=self.storage,
            compression=self.compression,
        )
        self._note(layer)
        return EnclosedOperator(self, layer)


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
