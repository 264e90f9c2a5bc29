"""The frozen-geometry implicit scheme: linear fluid response inside, geometry outside.

On a frozen geometry the fluid is a linear map of the velocity, ``load = R v``; it enters the
structure's Newton iteration as damping ``-R``. Only the geometry is iterated, and that contracts
fast at any mass ratio (faster still with quasi-Newton differences): 1 to 3 assemblies a step,
where partitioned schemes need m dt S < 20. It starts with the acceleration of the last steps.
R is a dense block while that is cheaper; beyond, the structure applies it inside GMRES, one frozen
fluid solve an iteration.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator

from ..exchange import Result
from .quasi_newton import QuasiNewton
from .relaxation import Relaxation
from .scheme import Memory, Scheme, StepProblem, StepResult

# Vector dofs up to which a dense response costs less. Measured a pass: 8 ms to form it and factor
# the tangents of 200 dofs, growing with their cube; 14 ms for some 15 frozen solves, whose calls
# count most up to there.
DENSE_LIMIT = 250


class DenseDamping:
    """``-R`` of a fluid response R as an array on request."""

    def __init__(self, response: LinearOperator):
        self._response = response

    def dense(self) -> np.ndarray:
        """The array."""
        return -self._response.dense()

    def __matmul__(self, velocity: np.ndarray) -> np.ndarray:
        return -(self._response @ velocity)


class MatrixFreeDamping(LinearOperator):
    """``-R`` by its action only; counts the frozen fluid solves."""

    def __init__(self, response: LinearOperator):
        super().__init__(dtype=np.dtype(float), shape=response.shape)
        self._response, self.solves = response, 0

    def _matvec(self, velocity: np.ndarray) -> np.ndarray:
        self.solves += 1
        return -(self._response @ velocity)


@dataclass(frozen=True)
class Implicit(Scheme):
    """Geometry iterated around a coupled linear solve.

    Parameters
    ----------
    dense_limit : int
        Vector dofs up to which the response is formed as an array, where the fluid can do that.
    passes : int
        Largest number of geometry passes that are accepted as they are: 1 is the semi-implicit
        scheme, on the predicted geometry; its error, first order in dt, is reported and not
        controlled. 0 iterates the geometry until it stands.
    geometry : Relaxation
        Of the geometry iteration, which by itself contracts by 0.1 to 0.3 a pass. Differences of
        the last steps save a quarter of the passes.
    """

    dense_limit: int = DENSE_LIMIT
    passes: int = 0
    geometry: Relaxation[Any] = field(default_factory=lambda: QuasiNewton(1.0, reuse=4))

    def init(self) -> Memory:
        return self.geometry.pack(self.geometry.init())

    def reset(self, memory: Memory) -> Memory:
        return self.init()

    def _damping(self, response: LinearOperator) -> DenseDamping | MatrixFreeDamping:
        small = response.shape[0] <= self.dense_limit and hasattr(response, "dense")
        return DenseDamping(response) if small else MatrixFreeDamping(response)

    def _first(
        self, problem: StepProblem, memory: Memory
    ) -> tuple[np.ndarray, Result | None, np.ndarray | None]:
        """First geometry, why there is none, and where Newton's iteration starts if that is tested.

        It goes on with the acceleration of the last steps, or without, where that can be reached.
        """
        wanted = problem.predictor
        if "turn" in memory and memory["dt"] == problem.dt:
            curved = wanted + memory["turn"]
            if problem.inspect(curved) is None:
                return curved, None, curved if problem.tests else None
        return *problem.reachable(wanted, problem.accepted), None

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        geometry, failure, guess = self._first(problem, memory)
        new = geometry
        newton = solves = 0
        structure, limit = problem.structure, self.passes or problem.max_iterations
        carried = self.geometry.next_step(self.geometry.unpack(memory))
        for i in range(1, limit + 1):
            if i > 1:
                geometry, failure = problem.reachable(geometry, new)
            if failure is not None:
                return StepResult(failure, None, iterations=i, assemblies=i - 1)
            operator = problem.assemble(geometry)
            damping = self._damping(operator.response())
            step = structure.step(
                problem.state,
                operator.drive(),
                problem.dt,
                problem.volume,
                damping=damping,
                guess=guess,
            )
            newton += step.newton_iterations
            solves += getattr(damping, "solves", 0)
            if not step.ok:
                return StepResult(Result.NEWTON, None, iterations=i, assemblies=i)
            new = step.state.coefficients
            change = new - geometry
            done, size = problem.converged(change, new)
            done = done or i == self.passes
            problem.report(i, size, 1.0, done)
            geometry, carried = self.geometry.step(carried, geometry, change)
            guess = new
            if done:
                traction = operator.traction(step.state.velocity)
                return StepResult(
                    None,
                    step,
                    operator.load(traction),
                    traction,
                    {**self.geometry.pack(carried), **_motion(problem, new, memory)},
                    iterations=i,
                    assemblies=i,
                    newton_iterations=newton,
                    krylov_iterations=traction.iterations,
                    frozen_solves=solves,
                )
        return StepResult(Result.COUPLING, None, iterations=i, assemblies=i)


def _motion(problem: StepProblem, new: np.ndarray, memory: Memory) -> dict[str, np.ndarray]:
    """A step's way, and what it has changed against that of the step before."""
    found = {"way": new - problem.accepted, "dt": np.array(problem.dt)}
    if "way" in memory and memory["dt"] == problem.dt:
        found["turn"] = found["way"] - memory["way"]
    return found


@dataclass(frozen=True)
class StructureOnly(Scheme):
    """No fluid: one structure solve a step, the enclosed volume as only load."""

    def init(self) -> Memory:
        return {}

    def reset(self, memory: Memory) -> Memory:
        return memory

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        step = problem.structure.step(problem.state, None, problem.dt, problem.volume)
        problem.report(1, 0.0, 1.0, step.ok)
        if not step.ok:
            return StepResult(Result.NEWTON, None, iterations=1)
        newton = step.newton_iterations
        return StepResult(None, step, memory=memory, iterations=1, newton_iterations=newton)
