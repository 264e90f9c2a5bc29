"""One time step as a problem, and its solution or the reason why there is none.

A scheme has the shape ``init() -> memory``, ``attempt(problem, memory) -> StepResult``; memory is
an immutable mapping of arrays that goes into checkpoints unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ..exchange import Result, State, Traction
from ..protocols import Fluid, FluidOperator, Structure, StructureStep

Memory = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Tolerances:
    """Stopping test of the fluid-structure iteration.

    Parameters
    ----------
    relative : float
        Last change of the iterate over the increment of the step.
    absolute : float
        Change added to that, as a root mean square displacement.
    max_iterations : int
        Subiterations or geometry passes allowed in a step.
    """

    relative: float = 1e-4
    absolute: float = 1e-9
    max_iterations: int = 6


@dataclass(frozen=True)
class StepProblem:
    """One time step to be solved.

    Parameters
    ----------
    structure : Structure
    fluid : Fluid or None
        None for a uniform pressure.
    state : State
        What the structure steps from: the accepted state for backward Euler, the combination of
        past states that an `Integrator` of higher order makes of it.
    dt : float
        Length of the structure's step.
    volume : float
        Enclosed volume at the end of the step.
    tolerance, absolute_tolerance : float
        Stop when the iterate changes by less than ``tolerance`` of the step's increment plus
        ``absolute_tolerance`` (first steps hardly move).
    max_iterations : int
    report : callable
        ``report(iteration, residual, relaxation, converged)``.
    before : (n_full, 3) array, optional
        Accepted coefficients, which increments are measured from; default those of ``state``.
    inspect, verify : callable, optional
        Why a configuration must not be assembled (None: it may); one of them is called before
        every assembly: ``inspect`` for guesses and relaxed iterates, ``verify`` for what the
        structure has reached.
    tests : bool
        Whether they test the way to a guess, so that the structure need not.
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
    verify: Callable[[np.ndarray], Result | None] = lambda coefficients: None
    tests: bool = False

    @property
    def accepted(self) -> np.ndarray:
        """Coefficients at the start of the step."""
        return self.state.coefficients if self.before is None else self.before

    @property
    def predictor(self) -> np.ndarray:
        """Configuration extrapolated with the last velocity."""
        return self.state.coefficients + self.dt * self.state.velocity

    def first_geometry(self) -> np.ndarray:
        """Predict the configuration, or take the accepted one where the predictor is unreachable.

        Returns
        -------
        (n_full, 3) array
        """
        return self.predictor if self.inspect(self.predictor) is None else self.accepted

    def reachable(
        self, wanted: np.ndarray, reached: np.ndarray
    ) -> tuple[np.ndarray, Result | None]:
        """Take the wanted configuration, or what the structure reached where that cannot be.

        Parameters
        ----------
        wanted, reached : (n_full, 3) array

        Returns
        -------
        (n_full, 3) array
        Result or None
            Why the structure's must not be assembled either.
        """
        if wanted is not reached and self.inspect(wanted) is None:
            return wanted, None
        return reached, self.verify(reached)

    def assemble(self, coefficients: np.ndarray) -> FluidOperator[Any]:
        """Assemble the fluid on a geometry.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        FluidOperator

        Raises
        ------
        ValueError
            There is no fluid: `StructureOnly` is the scheme for that.
        """
        if self.fluid is None:
            raise ValueError("this scheme couples a fluid; use StructureOnly where there is none")
        return self.fluid.assemble(coefficients)

    def converged(self, change: np.ndarray, new: np.ndarray) -> tuple[bool, float]:
        """Compare the last change of the iterate with the step's increment.

        Parameters
        ----------
        change : (n_full, 3) array
        new : (n_full, 3) array
            Newest iterate.

        Returns
        -------
        bool
            Whether the change is within the tolerance.
        float
            Size of the change relative to the increment.
        """
        size = self.structure.measure(change)
        increment = self.structure.measure(new - self.accepted)
        bound = self.tolerance * increment + self.absolute_tolerance
        return size <= bound, size / max(increment, 1e-300)


@dataclass(frozen=True)
class StepResult:
    """What a scheme returns: the solved time step, or why it failed.

    Parameters
    ----------
    failure : Result or None
        Why there is no solution; None where the step is solved.
    step : StructureStep, optional
        Solution of the structure; None after a failure.
    load : (n_full, 3) array, optional
        Load of the fluid that the step was solved with.
    traction : Traction, optional
    memory : mapping of arrays
        What the scheme carries to the next step.
    iterations, assemblies, newton_iterations, krylov_iterations, frozen_solves : int
        Work done; ``frozen_solves`` are fluid solves on a frozen geometry inside GMRES.
    notes : tuple of str
        Lines for the log.
    """

    failure: Result | None
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

    @property
    def state(self) -> State:
        """State at the end of a solved step; ValueError after a failure."""
        if self.step is None:
            raise ValueError("the step has no state, since it was not solved")
        new = self.step.state
        return State(new.t, new.coefficients, new.velocity, new.pressure)


class Scheme(Protocol):
    """A way to solve one coupled time step."""

    def init(self) -> Memory:
        """Make the memory that a run starts with.

        Returns
        -------
        mapping of arrays
        """

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        """Solve a time step, or say why that failed; nothing else changes.

        Parameters
        ----------
        problem : StepProblem
        memory : mapping of arrays
            Of the last accepted step.

        Returns
        -------
        StepResult
        """

    def reset(self, memory: Memory) -> Memory:
        """Make the memory for repeating a step that was rejected.

        Parameters
        ----------
        memory : mapping of arrays
            Of the last accepted step.

        Returns
        -------
        mapping of arrays
        """
