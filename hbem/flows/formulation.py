"""Boundary integral formulations of Stokes flow: the right-hand sides of ``V tau = F``.

With n outward, ``lambda`` exterior over interior viscosity, tractions in units of the interior
viscosity and ``tau_j = tau_i - tau_e``:

    interior  V tau_i = u/2 + K u                                   [T 3.8], lambda = 0
    exterior  V tau_e = -u/2 + K u + u_inf                          [T 5.3], outer viscosity
    jump      V tau_j = (1 + lambda)/2 u + (1 - lambda) K u - lambda u_inf     [T 5.4]

The double layer K is needed only for ``lambda != 1``.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import LinearOperator


def needs_double_layer(viscosity_ratio: float) -> bool:
    """Whether the double layer enters at this viscosity ratio (remark 35 of the thesis)."""
    return viscosity_ratio != 1.0


def jump_data(
    velocity: np.ndarray,
    viscosity_ratio: float,
    double: LinearOperator | None,
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
    double : LinearOperator or None
        The double layer; not used for ``lambda = 1``.
    projected : array, optional
        Coefficients of u in the density space, ``M^-1`` times the tested velocity.
    background : array or float
        Tested velocity at infinity.

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
