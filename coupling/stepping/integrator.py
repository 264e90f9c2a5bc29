"""Time integrators as implicit Euler steps from a combined past state.

BDF2 with step ratio w = dt_n / dt_{n-1} reads ``v = (x - b) / (g dt)``, ``a = (v - c) / (g dt)``,
g = (1 + w) / (1 + 2 w), b and c the combinations ``((1 + w)^2 y_n - w^2 y_{n-1}) / (1 + 2 w)`` of
positions and velocities: an Euler step of length g dt from (b, c). Both damp infinitely stiff
modes at once, which the volume multiplier asks for: trapezoidal rules oscillate with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..exchange import State

Past = Mapping[str, np.ndarray]


class Integrator(Protocol):
    """What the time loop asks of an integrator; ``past`` goes into checkpoints."""

    @property
    def order(self) -> int:
        """Order of convergence."""

    def base(self, state: State, past: Past, dt: float) -> tuple[State, float]:
        """Give the state and the length of the Euler step that makes this step.

        Parameters
        ----------
        state : State
            Accepted state.
        past : mapping of arrays
            What `past` returned for the step before; empty in a first step.
        dt : float

        Returns
        -------
        State
        float
        """

    def past(self, state: State, dt: float) -> Past:
        """Give what the next step needs to know of this one.

        Parameters
        ----------
        state : State
            State at the start of a step.
        dt : float
            Its length.

        Returns
        -------
        mapping of arrays
        """

    def error(self, before: State, after: State, past: Past, dt: float) -> np.ndarray:
        """Estimate the local error of the new coefficients.

        Parameters
        ----------
        before, after : State
        past : mapping of arrays
        dt : float

        Returns
        -------
        (n_full, 3) array
        """


@dataclass(frozen=True)
class BackwardEuler(Integrator):
    """First order [T 6.11].

    Parameters
    ----------
    order : int
        1; for the step control.
    """

    order: int = 1

    def base(self, state: State, past: Past, dt: float) -> tuple[State, float]:
        return state, dt

    def past(self, state: State, dt: float) -> Past:
        return {}

    def error(self, before: State, after: State, past: Past, dt: float) -> np.ndarray:
        # half the distance to the explicit predictor: dt^2 a / 2
        return 0.5 * (after.coefficients - before.coefficients - dt * before.velocity)


@dataclass(frozen=True)
class BDF2(Integrator):
    """Second order; its first step is backward Euler's.

    Parameters
    ----------
    order : int
        2; for the step control.
    """

    order: int = 2

    def base(self, state: State, past: Past, dt: float) -> tuple[State, float]:
        if not past:
            return state, dt
        w = dt / float(past["dt"])
        new, old, gamma = (1.0 + w) ** 2, w**2, (1.0 + w) / (1.0 + 2.0 * w)

        def combined(y: np.ndarray, before: np.ndarray) -> np.ndarray:
            return (new * y - old * before) / (1.0 + 2.0 * w)

        t = state.t + (1.0 - gamma) * dt  # the Euler step of gamma dt ends at t_n + dt
        x = combined(state.coefficients, past["coefficients"])
        v = combined(state.velocity, past["velocity"])
        return State(t, x, v, state.pressure), gamma * dt

    def past(self, state: State, dt: float) -> Past:
        return {
            "coefficients": state.coefficients,
            "velocity": state.velocity,
            "dt": np.array(dt),
        }

    def error(self, before: State, after: State, past: Past, dt: float) -> np.ndarray:
        # the quadratic predictor is 5/12 dt^3 x''' off, the step 2/9 on the other side
        if not past:
            return BackwardEuler().error(before, after, past, dt)
        change = (before.velocity - past["velocity"]) / float(past["dt"])
        predictor = before.coefficients + dt * before.velocity + 0.5 * dt**2 * change
        return 8.0 / 23.0 * (after.coefficients - predictor)
