"""Contraction of partitioned subiterations: ``rho = m dt S`` before, and measured.

The fluid acts as added damping, so rho grows with dt (unlike added mass): S is the larger of the
free-surface symbol 2 pi / h and the lubrication symbol 9.73 l^2 / H^3 of a gap of height H and
length l, closed at one end. It leaves out the structure's stiffness, which makes the true rho
smaller at large dt: little for plane sheets, by half for the tilting mode of a round bag, whose
rim cannot open without stretching.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs


def contraction_forecast(
    mass_ratio: float, dt: float, *, element_size: float, gap: float, extent: float
) -> float:
    """Estimate rho a priori from the narrowest region of a geometry.

    Parameters
    ----------
    mass_ratio : float
        m.
    dt : float
    element_size : float
        h of the free-surface symbol 2 pi / h.
    gap, extent : float
        Height H and length l of the narrowest region.

    Returns
    -------
    float
    """
    surface = 2.0 * np.pi / element_size
    lubrication = 9.73 * extent**2 / gap**3
    return mass_ratio * dt * max(surface, lubrication)


def film_symbol(s: np.ndarray, thickness: np.ndarray) -> float:
    """Compute S of a plane film between two sheets, closed at both ends.

    Twice the largest eigenvalue of the inverse of ``-(H^3/12 p')' = v`` with the mean of p
    removed (Reynolds): pressure on both sheets for a closing speed of twice their own. A constant
    thickness gives ``24 / (k^2 H^3)``, k = pi / length.

    Parameters
    ----------
    s, thickness : (n,) array
        Ascending arc lengths along the film and its thickness there.

    Returns
    -------
    float
    """
    h = np.diff(s)
    conductivity = 2.0 / (thickness[1:] ** -3 + thickness[:-1] ** -3) / 12.0 / h
    stiffness, mass = np.zeros((2, s.size, s.size))
    for i, (a, length) in enumerate(zip(conductivity, h, strict=True)):
        stiffness[i : i + 2, i : i + 2] += a * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[i : i + 2, i : i + 2] += length / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return float(2.0 / eigh(stiffness, mass, eigvals_only=True)[1])


def measure_contraction(
    response: LinearOperator,
    inverse_tangent: LinearOperator,
    dt: float,
    *,
    tolerance: float = 1e-4,
) -> float:
    """Measure rho: the spectral radius of ``(M/dt^2 + W'' - p Q'')^-1 R / dt``.

    The inverse tangent keeps the volume, which removes that mode.

    Parameters
    ----------
    response : LinearOperator
        Velocity to load of the assembled fluid.
    inverse_tangent : LinearOperator
        Structure's inverse tangent including its volume row (`Structure.linearised`).
    dt : float
    tolerance : float
        Relative error allowed.

    Returns
    -------
    float
        Infinity where the iteration finds no eigenvalue.
    """
    return worst_mode(response, inverse_tangent, dt, tolerance=tolerance)[0]


def worst_mode(
    response: LinearOperator,
    inverse_tangent: LinearOperator,
    dt: float,
    *,
    tolerance: float = 1e-4,
) -> tuple[float, np.ndarray]:
    """`measure_contraction` and its mode, of unit length (real: the operator is nearly so)."""
    n = response.shape[0]
    operator = LinearOperator(
        (n, n), matvec=lambda x: inverse_tangent @ (response @ x) / dt, dtype=float
    )
    start = np.random.default_rng(0).standard_normal(n)
    try:
        values, modes = eigs(operator, k=2, v0=start, tol=tolerance)
    except ArpackNoConvergence as stalled:
        values, modes = stalled.eigenvalues, stalled.eigenvectors
    if not values.size:
        return float("inf"), start / np.linalg.norm(start)
    worst = int(np.abs(values).argmax())
    mode = modes[:, worst].real
    return float(np.abs(values[worst])), mode / np.linalg.norm(mode)


def starting_relaxation(requested: float, contraction: float) -> float:
    """First Aitken factor: ``min(requested, 1 / (1 + rho))``."""
    return min(requested, 1.0 / (1.0 + contraction))
