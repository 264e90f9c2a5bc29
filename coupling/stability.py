"""Contraction of partitioned subiterations: ``rho = m dt S`` before, and measured.

The fluid acts as added damping, so rho grows with dt (unlike added mass): S is the larger of the
free-surface symbol 2 pi / h and the lubrication symbol 9.73 l^2 / H^3 of a gap of height H and
length l, closed at one end. Bending and inertia make the true rho smaller at large dt.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs


def contraction_forecast(
    mass_ratio: float, dt: float, *, element_size: float, gap: float, extent: float
) -> float:
    """A-priori rho from the mass ratio, the step and the declared narrowest region."""
    surface = 2.0 * np.pi / element_size
    lubrication = 9.73 * extent**2 / gap**3
    return mass_ratio * dt * max(surface, lubrication)


def contraction_measured(
    response: LinearOperator,
    inverse_tangent: LinearOperator,
    dt: float,
    *,
    tolerance: float = 1e-4,
) -> float:
    """Spectral radius of ``(M/dt^2 + W'' - p Q'')^-1 R / dt`` with the volume mode removed.

    Parameters
    ----------
    response : LinearOperator
        Velocity to load of the assembled fluid.
    inverse_tangent : LinearOperator
        Structure's inverse tangent including its volume row (`Structure.linearised`).
    tolerance : float
        Relative error allowed.
    """
    n = response.shape[0]
    operator = LinearOperator(
        (n, n), matvec=lambda x: inverse_tangent @ (response @ x) / dt, dtype=float
    )
    start = np.random.default_rng(0).standard_normal(n)
    try:
        values = eigs(operator, k=2, v0=start, return_eigenvectors=False, tol=tolerance)
    except ArpackNoConvergence as stalled:
        values = stalled.eigenvalues
    return float(np.abs(values).max()) if values.size else float("inf")


def starting_relaxation(requested: float, contraction: float) -> float:
    """First Aitken factor: ``min(requested, 1 / (1 + rho))``."""
    return min(requested, 1.0 / (1.0 + contraction))
