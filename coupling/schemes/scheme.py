"""One try at a time step: what a scheme receives and what it hands back.

A scheme has the shape ``init() -> memory``, ``attempt(problem, memory) -> Attempt``; memory is an
immutable mapping of arrays that goes into checkpoints unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..protocols import Fluid, Result, State, Structure, StructureStep, Traction

Memory = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class StepProblem:
    """One time step to be solved.

    Attributes
    ----------
    volume : float
        Enclosed volume at the end of the step.
    tolerance, absolute_tolerance : float
        Stop when the iterate changes by less than ``tolerance`` of the step's increment plus
        ``absolute_tolerance`` (first steps hardly move).
    report : callable
        ``report(iteration, residual, relaxation, converged)``.
    state, dt
        What the structure steps from and over: the accepted state for backward Euler, the
        combination of past states that an `integrator` of higher order makes of it.
    before : (n_full, 3) array, optional
        Accepted coefficients, which increments are measured from; default those of ``state``.
    inspect : callable
        Why a configuration must not be assembled (None: it may); called before every assembly.
    """

    structure: Structure
    fluid: Fluid | None
    state: State
    dt: float
    volume: float
    tolerance: float
    absolute_tolerance: float
    max_iterations: int
    report: Callable[[int, float, float, bool], None]
    before: np.ndarray | None = None
    inspect: Callable[[np.ndarray], Result | None] = lambda coefficients: None

    @property
    def accepted(self) -> np.ndarray:
        """Coefficients at the start of the step."""
        return self.state.coefficients if self.before is None else self.before

    @property
    def predictor(self) -> np.ndarray:
        """Configuration extrapolated with the last velocity."""
        return self.state.coefficients + self.dt * self.state.velocity

    def first_geometry(self) -> np.ndarray:
        """The predictor, or the accepted configuration where the predictor folds over itself."""
        return self.predictor if self.inspect(self.predictor) is None else self.accepted

    def converged(self, change: np.ndarray, new: np.ndarray) -> tuple[bool, float]:
        """Whether ``change`` is small against the step's increment, and its relative size."""
        size = self.structure.measure(change)
        increment = self.structure.measure(new - self.accepted)
        bound = self.tolerance * increment + self.absolute_tolerance
        return size <= bound, size / max(increment, 1e-300)


@dataclass(frozen=True)
class Attempt:
    """Outcome of a try: the accepted structure step, or the cause of failure."""

    cause: Result | None
    step: StructureStep | None = None
    load: np.ndarray | None = None
    traction: Traction | None = None
    memory: Memory = field(default_factory=dict)
    iterations: int = 0
    assemblies: int = 0
    newton_iterations: int = 0
    krylov_iterations: int = 0
    frozen_solves: int = 0
    notes: tuple[str, ...] = ()


class Scheme(Protocol):
    """A way to solve one coupled time step."""

    def init(self) -> Memory: ...

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt: ...

    def reset(self, memory: Memory) -> Memory:
        """Memory after a rejected step."""
