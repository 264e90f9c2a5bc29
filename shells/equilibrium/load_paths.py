"""Paths of static equilibria: load or volume in stations, each increment halved where Newton fails.

Every accepted point starts the next solve; increments grow again after successes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..conditions.loads import Follower
from .newton import NewtonOutcome
from .state import ShellState, ShellStep
from .structure import ShellStructure

# Flexural rigidity over length^2 below which no path leaves a flat unstressed state: of a square
# sheet under pressure, 274 iterations at 1e-8, none found at 1e-12.
SLENDER = 1e-9


def remedy(outcome: NewtonOutcome, structure: ShellStructure, dead: bool = True) -> str:
    """What helps after a failed solve.

    Parameters
    ----------
    outcome : NewtonOutcome
    structure : ShellStructure
    dead : bool
        The loads have a potential that `minimise` descends; one that follows the shell has none.
    """
    descent = ", or use shells.minimise" if dead else ""
    slender = SLENDER * structure.length**2
    if structure.shell.material.flexural_rigidity < slender:
        return (
            "with so little flexural rigidity an unstressed shell resists nothing across itself: "
            "start from a configuration that its edges stretch (a shallow bulge towards the load "
            f"is enough), give it flexural_rigidity above {slender:.0e}{descent}"
        )
    if outcome is NewtonOutcome.SINGULAR:
        return f"support the free motion, prestress the shell{descent}"
    if outcome is NewtonOutcome.DIVERGED:
        return f"control a volume or displacement instead of the load{descent}, or refine the mesh"
    return f"raise max_iterations of ShellStructure{descent}"


@dataclass(frozen=True)
class Path:
    """Equilibria at stations, and where the path ended.

    Attributes
    ----------
    steps : tuple of ShellStep
        One for each station reached.
    state : ShellState
        Last converged state, also between stations.
    parameter : float
        Its path parameter.
    newton_iterations : int
        All of them, those of failed increments too.
    failure : str
        Empty, or which step failed, its residual and the remedy.
    increment : float
        What the next step would have tried; a path that goes on with it repeats one that never
        stopped.
    """

    steps: tuple[ShellStep, ...]
    state: ShellState
    parameter: float
    newton_iterations: int
    failure: str = ""
    increment: float = float("nan")

    @property
    def ok(self) -> bool:
        """Whether the path reached its last station."""
        return not self.failure


def follow(
    solve: Callable[[float, ShellState], ShellStep],
    state: ShellState,
    start: float,
    stations: Sequence[float],
    *,
    floor: float = 1e-6,
    increment: float | None = None,
    accepted: Callable[[Path], None] = lambda path: None,
    remedied: Callable[[NewtonOutcome], str] = lambda outcome: "smaller stations",
) -> Path:
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
        Smallest increment over the length of the whole path; below it the path ends.
    increment : float, optional
        First one to try; default all the way to the first station.
    accepted : callable
        Hears the path so far at each station.
    remedied : callable
        What helps after an outcome, for the message.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        Without a station beyond the start.
    """
    if not len(stations) or stations[0] == start:
        raise ValueError(f"a path needs stations, the first beyond its start {start:g}")
    steps: list[ShellStep] = []
    current, newton = start, 0
    smallest = floor * abs(stations[-1] - start)
    increment = stations[0] - start if increment is None else increment
    for number, target in enumerate(stations, 1):
        while abs(target - current) > 1e-13 * max(abs(target), abs(start)):
            left = target - current
            tried = left if abs(left) <= abs(increment) else np.copysign(increment, left)
            trial = solve(current + tried, state)
            newton += trial.newton_iterations
            if trial.ok:
                current, state, last = current + tried, trial.state, trial
                increment = 1.5 * abs(tried) if abs(tried) >= abs(increment) else abs(increment)
                continue
            increment = 0.5 * abs(tried)
            if increment < smallest:
                failure = (
                    f"step {number} of {len(stations)} (to {target:g}) stopped at {current:.6g}, "
                    f"no equilibrium beyond it was found: {trial.outcome.value}; residual "
                    f"{trial.residual:.1e} of its start at increment {tried:.1e}; remedy: "
                    f"{remedied(trial.outcome)}"
                )
                return Path(tuple(steps), state, current, newton, failure, increment)
        steps.append(last)
        accepted(Path(tuple(steps), state, current, newton, increment=increment))
    return Path(tuple(steps), state, current, newton, increment=increment)


def static_path(
    structure: ShellStructure, coefficients: np.ndarray, volumes: Sequence[float]
) -> Path:
    """Equilibria along growing enclosed volumes, each step halved where Newton fails.

    Parameters
    ----------
    structure : ShellStructure
        With an enclosed volume.
    coefficients : (n_full, 3) array
        Configuration at the start.
    volumes : sequence of float
        Stations.

    Returns
    -------
    Path
        A step for each station reached; ``ok`` and ``failure`` tell why there are no more.

    Raises
    ------
    ValueError
        Without a volume beyond that of the start.
    """

    def solve(volume: float, state: ShellState) -> ShellStep:
        return structure.static(state.coefficients, volume, pressure=state.pressure)

    start = ShellState(0.0, coefficients, np.zeros_like(coefficients))
    return follow(
        solve,
        start,
        structure.volume(coefficients),
        list(volumes),
        remedied=lambda outcome: remedy(outcome, structure),
    )


def load_path(
    structure: ShellStructure,
    coefficients: np.ndarray,
    load: Callable[[float], np.ndarray | Follower],
    fractions: Sequence[float],
    *,
    start: float = 0.0,
    **options: Any,
) -> Path:
    """Equilibria at fractions of a load, each step halved where Newton fails.

    Parameters
    ----------
    structure : ShellStructure
    coefficients : (n_full, 3) array
        Equilibrium at the fraction ``start``.
    load : callable
        ``load(fraction)`` returns a load as `ShellStructure.static` takes it.
    fractions : sequence of float
        Stations.
    start : float
    **options
        ``floor``, ``increment`` and ``accepted`` of `follow`.

    Returns
    -------
    Path
        A step for each station reached; ``ok`` and ``failure`` tell why there are no more.

    Raises
    ------
    ValueError
        Without a fraction beyond the start; supports that leave a rigid motion free.
    """

    def solve(fraction: float, state: ShellState) -> ShellStep:
        return structure.static(state.coefficients, load=load(fraction))

    state = ShellState(0.0, coefficients, np.zeros_like(coefficients))
    dead = not callable(load(fractions[0])) if len(fractions) else True
    options["remedied"] = lambda outcome: remedy(outcome, structure, dead)
    return follow(solve, state, start, list(fractions), **options)
