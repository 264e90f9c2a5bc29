"""Prescribed enclosed volume: cosine ramps up and down around a constant influx [T 6.3.3].

``V(t) = V0 + (V_T - V0) int_0^t T``, T rising over t1, constant until t2, falling over t1: the
influx ends at t1 + t2 and its integral is one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def ramp_integral(t: float, t1: float, t2: float) -> float:
    """Integral of T from 0 to t, in closed form."""

    def rising(tau: float) -> float:
        return 0.5 * (tau - t1 / np.pi * np.sin(np.pi * tau / t1))

    if t <= 0.0:
        return 0.0
    total = rising(min(t, t1))
    total += max(0.0, min(t, t2) - t1)
    if t > t2:
        tau = min(t - t2, t1)
        total += 0.5 * (tau + t1 / np.pi * np.sin(np.pi * tau / t1))
    return total / t2


def prescribed_volume(
    initial: float, final: float, t1: float, t2: float
) -> Callable[[float], float]:
    """V(t) from the initial volume of the fitted bag, the final one and the times of the ramps."""

    def volume(t: float) -> float:
        return initial + (final - initial) * ramp_integral(t, t1, t2)

    return volume
