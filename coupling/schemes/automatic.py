"""Choice of the scheme by rho = m dt S, measured as the run goes, and change when a step fails.

Below ``limit`` the cheap partitioned scheme costs less than the implicit one: it takes more
assemblies, but forms no response. rho is measured by power iteration before the first step, and
again whenever the robust scheme has run ``rest`` steps, on the operator which that scheme
assembles anyway. The cheap scheme's turn ends with a busy step (the first, which has no
differences yet, may take twice as long) or a failed one, which is tried again at the same dt by
the robust scheme.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..protocols import Fluid, FluidOperator, Result
from .contraction import contraction_measured
from .scheme import Attempt, Memory, Scheme, StepProblem

FAILURES = (Result.COUPLING, Result.NEWTON)
ROUGH = 0.05  # relative error of a measured rho that decides between schemes


@dataclass(frozen=True)
class Automatic:
    """Two schemes and the rule between them.

    Parameters
    ----------
    rate : float
        rho / dt a priori, for a reader; the choice rests on the measured one.
    cheap, robust : Scheme
    limit : float
        The cheap scheme is used where rho is below: 1 where assembly is nearly all of the cost,
        more where forming the response counts.
    rest : int
        Steps of the robust scheme between measurements.
    most : int
        Subiterations above which a step of the cheap scheme is busy; twice as many for its first.
    """

    rate: float
    cheap: Scheme
    robust: Scheme
    limit: float = 1.0
    rest: int = 10
    most: int = 5

    def init(self) -> Memory:
        """``rate``: rho / dt; ``left``: robust steps to take before it is measured; ``turn``:
        cheap steps since the last change."""
        return self._memory(self.cheap.init(), self.robust.init(), rate=self.rate, left=0, turn=0)

    def _memory(
        self, cheap: Memory, robust: Memory, *, rate: float, left: int, turn: int
    ) -> dict[str, np.ndarray]:
        kept = {**_prefixed("cheap", cheap), **_prefixed("robust", robust)}
        return {**kept, "rate": np.array(rate), "left": np.array(left), "turn": np.array(turn)}

    def reset(self, memory: Memory) -> Memory:
        cheap = self.cheap.reset(_stripped("cheap", memory))
        robust = self.robust.reset(_stripped("robust", memory))
        choice = {name: memory[name] for name in ("rate", "left", "turn")}
        return {**_prefixed("cheap", cheap), **_prefixed("robust", robust), **choice}

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt:
        rate, left, turn = float(memory["rate"]), int(memory["left"]), int(memory["turn"])
        if left == 0 and turn == 0:
            return self._chosen(problem, memory)
        if left > 0:
            return self._robust(problem, memory, rate, left - 1)
        if rate * problem.dt >= self.limit:
            return self._robust(problem, memory, rate, self.rest - 1)
        return self._cheap(problem, memory, rate, turn)

    def _chosen(self, problem: StepProblem, memory: Memory) -> Attempt:
        """A step by the scheme that a measurement calls for."""
        geometry = problem.first_geometry()
        if problem.inspect(geometry) is not None:
            return self._robust(problem, memory, float(memory["rate"]), 0)
        operator = problem.fluid.assemble(geometry)
        rho = self._measured(problem, operator)
        rate, cheap = rho / problem.dt, rho < self.limit
        note = f"{'cheap' if cheap else 'robust'} scheme: measured rho = {rho:.2g}"
        if cheap:
            attempt = self._cheap(problem, memory, rate, 0)
            attempt = replace(attempt, assemblies=attempt.assemblies + 1)
        else:
            problem = replace(problem, fluid=_Held(problem.fluid, geometry, operator))
            attempt = self._robust(problem, memory, rate, self.rest - 1)
        return replace(attempt, notes=(note, *attempt.notes))

    def _cheap(self, problem: StepProblem, memory: Memory, rate: float, turn: int) -> Attempt:
        tried = self.cheap.attempt(problem, _stripped("cheap", memory))
        if tried.cause not in FAILURES:
            busy = tried.iterations > self.most * (1 if turn else 2)
            left, turn = (self.rest, 0) if busy else (0, turn + 1)
            kept = self._memory(tried.memory, self.robust.init(), rate=rate, left=left, turn=turn)
            return replace(tried, memory=kept)
        second = self._robust(problem, self.reset(memory), rate, self.rest)
        note = (
            f"changed to the robust scheme: {tried.cause.name} although rho = "
            f"{rate * problem.dt:.2g} < {self.limit:g}"
        )
        return replace(
            second,
            iterations=second.iterations + tried.iterations,
            assemblies=second.assemblies + tried.assemblies,
            newton_iterations=second.newton_iterations + tried.newton_iterations,
            krylov_iterations=second.krylov_iterations + tried.krylov_iterations,
            notes=(note, *second.notes),
        )

    def _measured(self, problem: StepProblem, operator: FluidOperator) -> float:
        inverse = problem.structure.linearised(problem.state, problem.dt)
        return contraction_measured(operator.response(), inverse, problem.dt, tolerance=ROUGH)

    def _robust(self, problem: StepProblem, memory: Memory, rate: float, left: int) -> Attempt:
        attempt = self.robust.attempt(problem, _stripped("robust", memory))
        # loads of the cheap scheme would be extrapolated across the steps in between
        kept = self._memory(self.cheap.init(), attempt.memory, rate=rate, left=left, turn=0)
        return replace(attempt, memory=kept)


@dataclass(frozen=True)
class _Held:
    """A fluid whose operator on one geometry exists already."""

    fluid: Fluid
    geometry: np.ndarray
    operator: FluidOperator

    def assemble(self, coefficients: np.ndarray) -> FluidOperator:
        if np.array_equal(coefficients, self.geometry):
            return self.operator
        return self.fluid.assemble(coefficients)


def _prefixed(name: str, memory: Memory) -> dict[str, np.ndarray]:
    return {f"{name}.{key}": value for key, value in memory.items()}


def _stripped(name: str, memory: Memory) -> dict[str, np.ndarray]:
    start = f"{name}."
    return {key[len(start) :]: v for key, v in memory.items() if key.startswith(start)}
