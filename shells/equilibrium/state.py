"""States of a structure and solved steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .newton import NewtonOutcome, NewtonResult


class MotionState(Protocol):
    """What a step reads of a state, whoever made it; `ShellState` says what it means."""

    @property
    def t(self) -> float: ...
    @property
    def coefficients(self) -> np.ndarray: ...
    @property
    def velocity(self) -> np.ndarray: ...
    @property
    def pressure(self) -> float: ...


@dataclass(frozen=True)
class ShellState:
    """Time, coefficients and velocity ``(n_full, 3)``, excess pressure."""

    t: float
    coefficients: np.ndarray
    velocity: np.ndarray
    pressure: float = 0.0


@dataclass(frozen=True)
class ShellStep:
    """A solved step, or (``ok`` false) why there is none.

    Attributes
    ----------
    state : ShellState
    outcome : NewtonOutcome
    newton_iterations : int
    residual : float
        Norm of the last residual over that of the start.
    factorizations : int
    """

    state: ShellState
    outcome: NewtonOutcome
    newton_iterations: int
    residual: float = np.inf
    factorizations: int = 0

    @classmethod
    def of(cls, state: ShellState, result: NewtonResult) -> ShellStep:
        """The step that ended in a state by an iteration of Newton's."""
        count = len(result.history)
        return cls(state, result.outcome, count, result.residual, result.factorizations)

    @property
    def ok(self) -> bool:
        """Whether Newton's iteration converged."""
        return self.outcome is NewtonOutcome.CONVERGED
