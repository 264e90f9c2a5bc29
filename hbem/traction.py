"""The traction of one solve: coefficients, multiplier, Krylov result, error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .traction_error import TractionError


@dataclass(frozen=True)
class Traction:
    """Fluid traction jump on one geometry.

    Parameters
    ----------
    coefficients : (n_dofs, 3) array
        Coefficients in the density space, per unit ``1/Re``.
    zeta : float
        Multiplier of ``<tau, n> = 0``.
    flux : float
        Discrete flux of the membrane velocity, which the influx follows.
    velocity_max : float
        Largest velocity on the boundary, inlet included.
    iterations : int
        Krylov iterations, 0 for a direct solve.
    residual : float
        True relative residual of the linear system.
    measure : callable, optional
        ``measure(krylov, quadrature, mesh)`` estimates the error of this traction: a
        `TractionError` with the Krylov share as given and those of quadrature and mesh where they
        are asked for, which costs some assemblies. None where nothing can be measured.
    """

    coefficients: np.ndarray
    zeta: float
    flux: float = 0.0
    velocity_max: float = 0.0
    iterations: int = 0
    residual: float = 0.0
    measure: Callable[[float, bool, bool], TractionError] | None = field(
        default=None, repr=False, compare=False
    )
