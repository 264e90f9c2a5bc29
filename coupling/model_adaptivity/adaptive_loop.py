"""The model-adaptive loop [T tab. 7.1]: solve, adjoint, estimate, enlarge the Navier-Stokes part.

It stops on the bound, since estimates may vanish by cancellation. A step whose solve did not
converge carries no estimate; its Navier-Stokes part grows by a layer and the loop goes on.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.newton import Solution, solve_robustly
from .error_estimate import Adjoint, Estimate, Indicator, add_layers, estimate
from .goals import Goal
from .marking import Marking, mark

logger = logging.getLogger(__name__)


class AdaptationResult(Enum):
    """Why the loop ended."""

    RUNNING = "not ended"
    COMPLETED = "the bound of the modelling error is below the tolerance"
    FULL_MODEL = "Navier-Stokes everywhere: no modelling error is left"
    STEP_LIMIT = "the step limit came before the tolerance: raise adaptivity.max_steps"
    NEWTON = "the flow could not be solved even in the full model: refine, or lower flow.reynolds"

    @property
    def ok(self) -> bool:
        """Whether the goal is as exact as was asked."""
        return self in (AdaptationResult.COMPLETED, AdaptationResult.FULL_MODEL)


@dataclass(frozen=True)
class Strategy:
    """How the loop adapts.

    Parameters
    ----------
    indicator : {"integral", "counting", "volume", "exact"}
        See `estimate`.
    adjoint : {"full", "mixed", "enriched"}
        See `estimate`.
    layers : int
        See `estimate`.
    marking : {"greedy", "fraction", "doerfler"}
        See `mark`.
    parameter : float
        Of the marking.
    tolerance : float
        For the bound relative to ``J(u0)``.
    max_steps : int
    """

    indicator: Indicator = "integral"
    adjoint: Adjoint = "full"
    layers: int = 1
    marking: Marking = "greedy"
    parameter: float = 0.1
    tolerance: float = 1e-3
    max_steps: int = 40


@dataclass(frozen=True)
class Step:
    """One step of the loop; relative figures are NaN where the solve did not converge.

    Parameters
    ----------
    index : int
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    solution : Solution
    estimated : Estimate or None
    element_fraction, volume_fraction : float
        Of the Navier-Stokes part.
    reference : float
        ``J(u1)`` of the full model; NaN if it was not computed.
    result : AdaptationResult
    seconds : dict
        Of the solve and of the estimate.
    """

    index: int
    flagged: np.ndarray
    solution: Solution
    estimated: Estimate | None
    element_fraction: float
    volume_fraction: float
    reference: float = float("nan")
    result: AdaptationResult = AdaptationResult.RUNNING
    seconds: dict[str, float] = field(default_factory=dict)

    def _relative(self, name: str) -> float:
        if self.estimated is None:
            return float("nan")
        return float(np.divide(getattr(self.estimated, name), self.estimated.goal))

    @property
    def goal(self) -> float:
        """``J(u0)``."""
        return self.estimated.goal if self.estimated else float("nan")

    @property
    def estimate(self) -> float:
        """``R1(u0; z) / J(u0)``."""
        return self._relative("error")

    @property
    def thesis_eps(self) -> float:
        """The thesis' printed error: by its numbers the negative estimate, not its definition."""
        return -self.estimate

    @property
    def bound(self) -> float:
        """Sum of the indicators' magnitudes over ``|J(u0)|``."""
        return abs(self._relative("bound"))

    @property
    def algebraic(self) -> float:
        """What is left of Newton's residual, in the goal, relative to ``J(u0)``."""
        return self._relative("algebraic")

    @property
    def error(self) -> float:
        """``(J(u1) - J(u0)) / J(u1)``."""
        return float(np.divide(self.reference - self.goal, self.reference))

    @property
    def error_rel_j0(self) -> float:
        """``(J(u1) - J(u0)) / J(u0)``."""
        return float(np.divide(self.reference - self.goal, self.goal))

    @property
    def effectivity(self) -> float:
        """Estimate over true error [T 7.29]."""
        if self.estimated is None or self.reference == self.goal:
            return float("nan")
        return self.estimated.error / (self.reference - self.goal)


def adapt(
    flow: MixedFlow,
    goal: Goal,
    strategy: Strategy | None = None,
    *,
    reference: float = float("nan"),
    flagged: np.ndarray | None = None,
    start: np.ndarray | None = None,
    first: int = 0,
) -> Iterator[Step]:
    """Run the adaptive loop; the last step's ``result`` says why it ended.

    Parameters
    ----------
    flow : MixedFlow
    goal : Goal
        Whose error is estimated and controlled.
    strategy : Strategy, optional
    reference : float
        ``J(u1)`` of the full model, for true errors.
    flagged : (n_elements,) bool array, optional
        Initial Navier-Stokes part; none by default.
    start : (n,) array, optional
        Initial guess.
    first : int
        Number of the first step, where a loop is taken up again.

    Yields
    ------
    Step
    """
    strategy = strategy or Strategy()
    flagged = flow.nowhere if flagged is None else flagged
    for index in range(first, strategy.max_steps + 1):
        began = time.perf_counter()
        found = solve_robustly(flow, flagged, start)
        solved = time.perf_counter()
        judged = None
        if found.ok:
            judged = estimate(
                flow,
                goal,
                found.x,
                flagged,
                indicator=strategy.indicator,
                adjoint=strategy.adjoint,
                layers=strategy.layers,
            )
            start = found.x
        seconds = {"solve": solved - began, "estimate": time.perf_counter() - solved}
        step = Step(
            index=index,
            flagged=flagged,
            solution=found,
            estimated=judged,
            element_fraction=float(flagged.mean()),
            volume_fraction=float(flow.space.volumes[flagged].sum() / flow.space.volumes.sum()),
            reference=reference,
            seconds=seconds,
        )
        result = _result(step, strategy)
        yield replace(step, result=result)
        if result is not AdaptationResult.RUNNING:
            return
        flagged = enlarge(flow, step, strategy)


def enlarge(flow: MixedFlow, step: Step, strategy: Strategy) -> np.ndarray:
    """Enlarge the Navier-Stokes part by what is marked.

    A layer is added where there is no estimate or nothing is marked.
    """
    new = np.zeros_like(step.flagged)
    if step.estimated is not None:
        eta = step.estimated.indicators
        new = mark(eta, step.flagged, strategy.marking, strategy.parameter)
    else:
        logger.warning("step %d: %s", step.index, step.solution.outcome.value)
    if not new.any():
        new = add_layers(flow.space, step.flagged) if step.flagged.any() else flow.everywhere
    return step.flagged | new


def _result(step: Step, strategy: Strategy) -> AdaptationResult:
    if not step.solution.ok and step.flagged.all():
        return AdaptationResult.NEWTON
    if step.bound <= strategy.tolerance:
        return AdaptationResult.COMPLETED
    if step.flagged.all():
        return AdaptationResult.FULL_MODEL
    return (
        AdaptationResult.STEP_LIMIT
        if step.index == strategy.max_steps
        else AdaptationResult.RUNNING
    )


def full_model(flow: MixedFlow, goal: Goal) -> tuple[float, Solution]:
    """Solve Navier-Stokes in the whole domain.

    Parameters
    ----------
    flow : MixedFlow
    goal : Goal

    Returns
    -------
    float
        ``J(u1)``.
    Solution

    Raises
    ------
    ArithmeticError
        It did not converge.
    """
    found = solve_robustly(flow, flow.everywhere)
    if not found.ok:
        raise ArithmeticError(f"full model: {found.outcome.value}; residual {found.residual:.1e}")
    return goal.value(found.x), found
