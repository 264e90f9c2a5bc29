"""Paths of static equilibria: load or volume in stations, each increment halved where Newton fails.

Every accepted point starts the next solve; increments grow again after successes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .dynamics import Follower, ShellState, ShellStep, ShellStructure


def follow(
    solve: Callable[[float, ShellState], ShellStep],
    state: ShellState,
    start: float,
    stations: Sequence[float],
    *,
    floor: float = 1e-6,
) -> list[ShellStep]:
    """Equilibria at the stations of a path parameter.

    Parameters
    ----------
    solve : callable
        ``solve(parameter, state)`` starts Newton at the last accepted state.
    state : ShellState
    start : float
        Parameter of ``state``.
    stations : sequence of float
    floor : float
        Smallest increment over the length of the whole path.

    Raises
    ------
    ArithmeticError
        If an increment falls below the floor, with the parameter reached and Newton's outcome.
    """
    current, steps = start, []
    smallest = floor * abs(stations[-1] - start)
    increment = stations[0] - start
    for target in stations:
        while abs(target - current) > 1e-13 * max(abs(target), abs(start)):
            left = target - current
            tried = left if abs(left) <= abs(increment) else np.copysign(increment, left)
            trial = solve(current + tried, state)
            if trial.ok:
                current, state, last = current + tried, trial.state, trial
                increment = 1.5 * abs(tried) if abs(tried) >= abs(increment) else abs(increment)
                continue
            increment = 0.5 * abs(tried)
            if increment < smallest:
                raise ArithmeticError(
                    f"the path stopped at parameter {current:.6g}: {trial.outcome.value}"
                )
        steps.append(last)
    return steps


def static_path(
    structure: ShellStructure, coefficients: np.ndarray, volumes: Sequence[float]
) -> ShellStep:
    """Last of the equilibria along growing enclosed volumes (see `follow`)."""

    def solve(volume: float, state: ShellState) -> ShellStep:
        return structure.static(state.coefficients, volume, pressure=state.pressure)

    start = ShellState(0.0, coefficients, np.zeros_like(coefficients))
    return follow(solve, start, structure.volume(coefficients), list(volumes))[-1]


def load_path(
    structure: ShellStructure,
    coefficients: np.ndarray,
    load: Callable[[float], np.ndarray | Follower],
    fractions: Sequence[float],
) -> list[ShellStep]:
    """Equilibria at fractions of a load; ``load(fraction)`` is what `static` takes."""

    def solve(fraction: float, state: ShellState) -> ShellStep:
        return structure.static(state.coefficients, load=load(fraction))

    start = ShellState(0.0, coefficients, np.zeros_like(coefficients))
    return follow(solve, start, 0.0, list(fractions))
