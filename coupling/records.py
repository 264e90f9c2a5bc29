"""What the time loop tells: subiterations, rejected and accepted steps, checkpoints, the end.

A `Recorder` receives them; it never changes them. The loop itself writes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .exchange import Result, State, Traction


@dataclass(frozen=True)
class Iteration:
    """One subiteration.

    Parameters
    ----------
    step : int
    t, dt : float
        End of the step and its length.
    iteration : int
    residual : float
        Last change over the increment of the step.
    relaxation : float
    converged : bool
    """

    step: int
    t: float
    dt: float
    iteration: int
    residual: float
    relaxation: float
    converged: bool


@dataclass(frozen=True)
class Rejection:
    """A step that was rolled back as a whole.

    Parameters
    ----------
    step : int
    t, dt : float
        End of the step and its length.
    cause : Result
    iterations : int
        Taken in vain.
    """

    step: int
    t: float
    dt: float
    cause: Result
    iterations: int


@dataclass(frozen=True)
class AcceptedStep:
    """An accepted step.

    Parameters
    ----------
    step : int
    state : State
    row : mapping of float
        Its line of the history.
    traction : Traction or None
        None without a fluid and at the start.
    """

    step: int
    state: State
    row: Mapping[str, float]
    traction: Traction | None


@dataclass(frozen=True)
class Snapshot:
    """Everything a run needs to continue with the same arithmetic: the checkpoint.

    Parameters
    ----------
    step : int
    dt : float
        Length of the next step.
    state : State
    accumulated : mapping of float
        Running sums of the history.
    memory : mapping of arrays
        What scheme and integrator carry from step to step.
    """

    step: int
    dt: float
    state: State
    accumulated: Mapping[str, float]
    memory: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Parameters
    ----------
    result : Result
    step : int
    t : float
        Time reached.
    counts : mapping
        Totals: steps, assemblies, iterations.
    detail : str
        Advice.
    """

    result: Result
    step: int
    t: float
    counts: Mapping[str, float]
    detail: str = ""

    @property
    def where(self) -> str:
        """Step and time, for messages."""
        return f"step {self.step}, t = {self.t:g}"

    @property
    def summary(self) -> str:
        """Rejected steps and assemblies, for messages."""
        rejected, assemblies = (self.counts.get(k, 0) for k in ("rejected", "assemblies"))
        return f"{rejected} rejected steps, {assemblies} assemblies"


class Recorder(Protocol):
    """Receives what happens; never changes it."""

    def on_start(self, step: AcceptedStep) -> None:
        """Receive the initial state.

        Parameters
        ----------
        step : AcceptedStep
        """

    def on_iteration(self, iteration: Iteration) -> None:
        """Receive a subiteration.

        Parameters
        ----------
        iteration : Iteration
        """

    def on_accepted(self, step: AcceptedStep) -> None:
        """Receive an accepted step.

        Parameters
        ----------
        step : AcceptedStep
        """

    def on_rejected(self, rejection: Rejection) -> None:
        """Receive a rejected step.

        Parameters
        ----------
        rejection : Rejection
        """

    def on_checkpoint(self, snapshot: Snapshot) -> None:
        """Receive what a run can be continued from.

        Parameters
        ----------
        snapshot : Snapshot
        """

    def on_note(self, step: int, text: str) -> None:
        """Receive what a reader of the log should know: a scheme changed, a step was limited.

        Parameters
        ----------
        step : int
        text : str
        """

    def close(self, outcome: Outcome) -> None:
        """Receive the end of the run.

        Parameters
        ----------
        outcome : Outcome
        """
