"""Stokes flow inside and outside a membrane, inflated through an inlet or closed in a background.

``V tau = (1 + lambda) / 2 u + (1 - lambda) K u - lambda u_inf``, ``<tau, n> = 0`` on the closed
surface [T 5.4]; equal viscosities leave out the double layer K. On an inlet the data are
``u = -(phi(v) / int X) X n`` with the discrete flux ``phi(v)`` of the membrane velocity, so the
total discrete flux vanishes and all but the background is linear in v, see `enclosed_operator`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..layers.choice import Compression
from ..layers.compressed_layer import CompressedSingleLayer
from ..layers.layer import SingleLayer
from ..layers.single_layer import single_layer
from ..solvers.preconditioner_reuse import PreconditionerStore
from ..solvers.saddle import DENSE_LIMIT
from ..solvers.saddle_system import Builder, MassPreconditioner, SaddleSolution
from ..solvers.schwarz import two_level_schwarz
from ..surfaces.patches import SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from .enclosed_operator import EnclosedOperator
from .enclosed_problem import EnclosedProblem, Profile, Velocity
from .formulation import JumpFormulation

BUILDERS: dict[str, Builder] = {"schwarz": two_level_schwarz, "mass": MassPreconditioner}


@dataclass(frozen=True)
class EnclosedStokes:
    """Stokes flow in and around a bag or a capsule.

    Parameters
    ----------
    patches : SurfacePatches
        Membrane and inlet, closed together, normals outward.
    inflow : (n_elements,) bool array
        Elements of the inlet; none of a closed membrane.
    profile : callable or None
        Inflow profile X on points ``(n, 3)``: ``(n,)``; the flow enters along the inward normal.
        None exactly if there is no inlet.
    mass_ratio : float
        ``m = varpi / Re`` of the fluid inside.
    viscosity_ratio : float
        Exterior over interior viscosity; other than 1 it needs the double layer.
    traction_tolerance : float
        Error asked of the traction, which measured errors are compared with, see
        `hbem.Traction.measure`.
    background : callable, optional
        Undisturbed velocity u_inf of the outer fluid at points ``(n, 3)``, itself a Stokes flow.
    orders : QuadratureOrders
    dense_limit : int
        Unknowns up to which the system is solved by LU.
    tolerance : float
        Relative residual of GMRES.
    max_iterations : int
    storage : {"auto", "dense", "direct"}
        Of the single layer; see `hbem.layers.single_layer.single_layer`.
    preconditioner : {"schwarz", "mass"}
        Of GMRES: two levels for gaps, the mass matrix for fat bodies. It is kept from one
        geometry to the next until it degrades or `reset` drops it.
    compression : Compression, optional
        Compress the single layer; it is then solved by GMRES at any size.

    Raises
    ------
    ValueError
        A negative viscosity ratio, a mass ratio that is not positive, an inflow array that does
        not fit or leaves no membrane, an inlet without profile, a profile without inlet, a
        background without outer fluid, or an unknown preconditioner.
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
    traction_tolerance: float = np.inf

    def __post_init__(self) -> None:
        _ = self.problem  # checks what belongs to it
        if self.preconditioner not in BUILDERS:
            raise ValueError(
                f"preconditioner must be 'schwarz' or 'mass', got {self.preconditioner!r}"
            )

    @cached_property
    def problem(self) -> EnclosedProblem:
        """Patches, inlet, ratios and background, checked."""
        return EnclosedProblem(
            self.patches,
            self.inflow,
            self.profile,
            self.mass_ratio,
            self.viscosity_ratio,
            self.background,
        )

    @cached_property
    def store(self) -> PreconditionerStore:
        """The preconditioner in use."""
        return PreconditionerStore(BUILDERS[self.preconditioner])

    @cached_property
    def statistics(self) -> dict[str, float | int | str]:
        """Figures of the latest compressed operator, and the worst errors so far."""
        return {}

    def reset(self) -> None:
        """Forget what is kept between geometries; runs do so at checkpoints."""
        self.store.drop()

    def assemble(self, coefficients: np.ndarray) -> EnclosedOperator:
        """Assemble the flow on one configuration.

        Parameters
        ----------
        coefficients : (n_coefficients, 3) array

        Returns
        -------
        EnclosedOperator

        Raises
        ------
        ValueError
            Coefficients of the wrong shape or not finite.
        MemoryError
            A compressed operator above ``compression.memory``.
        """
        layer = single_layer(
            self.patches,
            coefficients,
            self.orders,
            storage=self.storage,
            compression=self.compression,
        )
        self._record(layer)
        formulation = JumpFormulation(
            layer,
            self.viscosity_ratio,
            self.orders,
            self.tolerance,
            self.store,
            self.max_iterations,
            self.dense_limit,
        )

        def on_solve(solved: SaddleSolution) -> None:
            if solved.iterations:
                self.store.note(solved.iterations)

        return EnclosedOperator(
            self.problem,
            formulation,
            on_solve,
            self.traction_tolerance,
            self.preconditioner == "mass",
        )

    def _record(self, layer: SingleLayer) -> None:
        """Keep the figures of a compressed operator and the worst of all so far."""
        if not isinstance(layer, CompressedSingleLayer):
            return
        found = layer.statistics()
        worst = max(found["achieved"], self.statistics.get("worst_achieved", 0.0))
        self.statistics.update(found | {"worst_achieved": worst})
