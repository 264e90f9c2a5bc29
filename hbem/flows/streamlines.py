"""Streamlines of a flow, by arclength: ``dx/ds = u / |u|``, adaptive Runge-Kutta 4(5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.integrate import solve_ivp

Velocity = Callable[[np.ndarray], np.ndarray]
SLOW = 1e-9  # of the largest speed at the seeds: a line ends in fluid at rest


def streamlines(
    velocity: Velocity, seeds: np.ndarray, length: float, *, tolerance: float = 1e-4
) -> list[np.ndarray]:
    """Lines through seeds, forwards and backwards.

    Parameters
    ----------
    velocity : callable
        Points ``(n, 3)`` to velocities ``(n, 3)``; NaN where there is no flow ends a line.
    seeds : (n, 3) array
    length : float
        Arclength to each side.
    tolerance : float
        Error of the integrator, relative to ``length``.

    Returns
    -------
    list of (m, 3) arrays
        Points along each line, upstream first.

    Raises
    ------
    ValueError
        A length or tolerance that is not positive.
    """
    if not (length > 0.0 and tolerance > 0.0):
        raise ValueError(f"need length > 0 and tolerance > 0, got {length}, {tolerance}")
    seeds = np.atleast_2d(np.asarray(seeds, dtype=float))
    start = np.linalg.norm(velocity(seeds), axis=1)
    rest = SLOW * np.nanmax(start, initial=0.0)
    lines = []
    for seed in seeds:
        back, ahead = (_half(velocity, seed, side, length, tolerance, rest) for side in (-1, 1))
        lines.append(np.concatenate([back[:0:-1], ahead]))
    return lines


@dataclass(frozen=True)
class _Stopped:
    """Event of the integrator: the fluid is at rest, or there is none."""

    velocity: Velocity
    rest: float
    terminal: ClassVar[bool] = True

    def __call__(self, _: float, x: np.ndarray) -> float:
        speed = float(np.linalg.norm(self.velocity(x[None])[0]))
        return speed - self.rest if np.isfinite(speed) else -1.0


def _half(
    velocity: Velocity, seed: np.ndarray, side: int, length: float, tolerance: float, rest: float
) -> np.ndarray:
    def slope(_: float, x: np.ndarray) -> np.ndarray:
        u = velocity(x[None])[0]
        speed = np.linalg.norm(u)
        return side * u / speed if speed > rest else np.zeros(3)

    end = _Stopped(velocity, rest)
    found = solve_ivp(
        slope, (0.0, length), seed, rtol=tolerance, atol=tolerance * length, events=end
    )
    return found.y.T
