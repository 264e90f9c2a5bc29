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

from ..compression.choice import Compression
from ..layers.layer import SingleLayer
from ..layers.single_layer import single_layer
from ..solvers.preconditioner_reuse import PreconditionerStore
from ..solvers.saddle import DENSE_LIMIT, MassPreconditioner
from ..solvers.schwarz import two_level_schwarz
from ..surfaces.patches import SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from .enclosed_operator import EnclosedOperator

Profile = Callable[[np.ndarray], np.ndarray]
Velocity = Callable[[np.ndarray], np.ndarray]
BUILDERS = {"schwarz": two_level_schwarz, "mass": MassPreconditioner}


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

    def note(self, layer: SingleLayer, traction: np.ndarray | None = None) -> None:
        """Keep the figures of a compressed operator, and its error on a traction just solved."""
        if self.compression is None:
            return
        if traction is not None:
            layer.measure_on(traction, self.compression.expected_gap_error)
        found = layer.statistics()
        worst = {
            f"worst_{name}": max(found[name], self.statistics.get(f"worst_{name}", 0.0))
            for name in ("achieved", "error_gap", "error_traction")
            if found[name] == found[name]
        }
        self.statistics.update(found | worst)

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
        self.note(layer)
        return EnclosedOperator(self, layer)
