"""The barrier of contact, ``beta(s) = -(1 - s)^2 ln s`` of the distance over the reach.

It is 0 from ``s = 1`` on, twice continuously differentiable there, and infinite at 0. A quadratic
with its value, slope and curvature can continue it below some ``s``, for what may penetrate.
"""

from __future__ import annotations

import numpy as np


def barrier(s: np.ndarray, floor: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Barrier and its first two derivatives.

    Parameters
    ----------
    s : (k,) array
        Distance over the reach; positive where the floor is 0.
    floor : float
        Where the quadratic continuation begins.

    Returns
    -------
    three (k,) arrays
    """
    x = np.clip(s, floor, 1.0)
    log, rest = np.log(x), 1.0 - x
    value, slope = -(rest**2) * log, 2.0 * rest * log - rest**2 / x
    bend = -2.0 * log + 4.0 * rest / x + (rest / x) ** 2
    below = np.minimum(s - floor, 0.0) if floor > 0.0 else np.zeros_like(x)
    return value + slope * below + 0.5 * bend * below**2, slope + bend * below, bend


def contact_pressure(s: np.ndarray, floor: float = 0.0) -> np.ndarray:
    """Pressure over the stiffness, ``2 (1 - s)(-ln s) + (1 - s)^2 / s`` for ``s`` below 1."""
    return -barrier(s, floor)[1]
