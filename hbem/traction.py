"""The traction of one solve: coefficients, multiplier, Krylov result, error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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
    """

    coefficients: np.ndarray
    zeta: float
    flux: float = 0.0
    velocity_max: float = 0.0
    iterations: int = 0
    residual: float = 0.0
