"""Choice of the scheme by rho = m dt S, measured as the run goes.

The cheap partitioned scheme takes more assemblies a step than the robust implicit one, but forms
no response. It is used where rho, measured by power iteration, is below ``limit``, until a step
takes too many subiterations or fails; a failed step is solved again at the same dt by the robust
scheme. After ``remeasure_every`` robust steps rho is measured anew, on the operator that the
robust scheme assembles anyway.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..exchange import Result
from ..protocols import FluidOperator
from .contraction import measure_contraction
from .scheme import Memory, Scheme, StepProblem, StepResult

FAILURES = (Result.COUPLING, Result.NEWTON)
ROUGH = 0.05  # relative error of a measured rho that decides between schemes


@dataclass(frozen=True)
class Automatic(Scheme):
    """Two schemes and the rule that chooses between them.

    Parameters
    ----------
    rate : float
        rho / dt a priori, for a reader; the choice rests on the measured one.
    cheap, robust : Scheme
        For small and for any rho.
    limit : float
        The cheap scheme is used where rho is below: 1 where assembly is nearly all of the cost,
        more where forming the response counts.
    remeasure_every : int
        Steps of the robust scheme after which rho is measured again.
    max_subiterations : int
        The robust scheme takes over after a step of the cheap one that fails or takes more
        subiterations than this. The cheap scheme's first step may take twice as many, since it
        has no differences of earlier steps yet.
    """

    rate: float
    cheap: Scheme
    robust: Scheme
    limit: float = 1.0
    remeasure_every: int = 10
    max_subiterations: int = 5

    def init(self) -> Memory:
        # rate: rho / dt; left: robust steps before it is measured; turn: cheap steps in a row
        return self._memory(self.cheap.init(), self.robust.init(), rate=self.rate, left=0, turn=0)

    def _memory(
        self, cheap: Memory, robust: Memory, *, rate: float, left: int, turn: int
    ) -> dict[str, np.ndarray]:
        both = {**_prefixed("cheap", cheap), **_prefixed("robust", robust)}
        return {**both, "rate": np.array(rate), "left": np.array(left), "turn": np.array(turn)}

    def reset(self, memory: Memory) -> Memory:
        cheap = self.cheap.reset(_stripped("cheap", memory))
        robust = self.robust.reset(_stripped("robust", memory))
        choice = {name: memory[name] for name in ("rate", "left", "turn")}
        return {**_prefixed("cheap", cheap), **_prefixed("robust", robust), **choice}

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        rate, left, turn = float(memory["rate"]), int(memory["left"]), int(memory["turn"])
        if left == 0 and turn == 0:
            return self._measure_and_attempt(problem, memory)
        if left > 0:
            return self._robust(problem, memory, rate, left - 1)
        if rate * problem.dt >= self.limit:
            return self._robust(problem, memory, rate, self.remeasure_every - 1)
        return self._cheap(problem, memory, rate, turn)

    def _measure_and_attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        geometry = problem.first_geometry()
        if problem.inspect(geometry) is not None:
            return self._robust(problem, memory, float(memory["rate"]), 0)
        operator = problem.assemble(geometry)
        inverse = problem.structure.linearised(problem.state, problem.dt)
        rho = measure_contraction(operator.response(), inverse, problem.dt, tolerance=ROUGH)
        rate, cheap = rho / problem.dt, rho < self.limit
        note = f"{'cheap' if cheap else 'robust'} scheme: measured rho = {rho:.2g}"
        if cheap:
            result = self._cheap(problem, memory, rate, 0)
            result = replace(result, assemblies=result.assemblies + 1)
        else:
            problem = replace(problem, fluid=_AssembledOnce(problem, geometry, operator))
            result = self._robust(problem, memory, rate, self.remeasure_every - 1)
        return replace(result, notes=(note, *result.notes))

    def _cheap(self, problem: StepProblem, memory: Memory, rate: float, turn: int) -> StepResult:
        first = self.cheap.attempt(problem, _stripped("cheap", memory))
        if first.failure not in FAILURES:
            busy = first.iterations > self.max_subiterations * (1 if turn else 2)
            left, turn = (self.remeasure_every, 0) if busy else (0, turn + 1)
            new = self._memory(first.memory, self.robust.init(), rate=rate, left=left, turn=turn)
            return replace(first, memory=new)
        second = self._robust(problem, self.reset(memory), rate, self.remeasure_every)
        note = (
            f"changed to the robust scheme: {first.failure.name} although rho = "
            f"{rate * problem.dt:.2g} < {self.limit:g}"
        )
        return replace(
            second,
            iterations=second.iterations + first.iterations,
            assemblies=second.assemblies + first.assemblies,
            newton_iterations=second.newton_iterations + first.newton_iterations,
            krylov_iterations=second.krylov_iterations + first.krylov_iterations,
            notes=(note, *second.notes),
        )

    def _robust(self, problem: StepProblem, memory: Memory, rate: float, left: int) -> StepResult:
        result = self.robust.attempt(problem, _stripped("robust", memory))
        # loads of the cheap scheme would be extrapolated across the steps in between
        new = self._memory(self.cheap.init(), result.memory, rate=rate, left=left, turn=0)
        return replace(result, memory=new)


@dataclass(frozen=True)
class _AssembledOnce:
    """The fluid of a problem, whose operator on one geometry exists already."""

    problem: StepProblem
    geometry: np.ndarray
    operator: FluidOperator[Any]

    def assemble(self, coefficients: np.ndarray) -> FluidOperator[Any]:
        if np.array_equal(coefficients, self.geometry):
            return self.operator
        return self.problem.assemble(coefficients)

    def reset(self) -> None:
        """Nothing is stored beyond the step."""


def _prefixed(name: str, memory: Memory) -> dict[str, np.ndarray]:
    return {f"{name}.{key}": value for key, value in memory.items()}


def _stripped(name: str, memory: Memory) -> dict[str, np.ndarray]:
    start = f"{name}."
    return {key[len(start) :]: v for key, v in memory.items() if key.startswith(start)}
