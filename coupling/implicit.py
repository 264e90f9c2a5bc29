"""The frozen-geometry implicit scheme: linear fluid response inside, geometry outside.

On a frozen geometry the fluid is a linear map of the velocity, ``load = R v``; it enters the
structure's Newton iteration as damping ``-R``. Only the geometry is iterated, and that contracts
fast at any mass ratio: 2 to 4 assemblies a step, where partitioned schemes need m dt S < 20.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator

from .attempt import Attempt, Memory, StepProblem
from .protocols import Result


class Damping:
    """``-R`` of a fluid response R, dense on request."""

    def __init__(self, response: LinearOperator):
        self._response = response

    def dense(self) -> np.ndarray:
        return -self._response.dense()

    def __matmul__(self, velocity: np.ndarray) -> np.ndarray:
        return -(self._response @ velocity)


@dataclass(frozen=True)
class Implicit:
    """Geometry iteration around the implicit solve; no memory between steps."""

    def init(self) -> Memory:
        return {}

    def reset(self, memory: Memory) -> Memory:
        return memory

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt:
        geometry, guess, newton = problem.predictor, None, 0
        structure = problem.structure
        for i in range(1, problem.max_iterations + 1):
            operator = problem.fluid.assemble(geometry)
            damping = Damping(operator.response())
            step = structure.step(
                problem.state, None, problem.dt, problem.volume, damping=damping, guess=guess
            )
            newton += step.newton_iterations
            if not step.ok:
                return Attempt(Result.NEWTON, None, iterations=i, assemblies=i)
            new = step.state.coefficients
            done, size = problem.converged(new - geometry, new)
            problem.report(i, size, 1.0, done)
            if done:
                traction = operator.traction(step.state.velocity)
                return Attempt(
                    None,
                    step,
                    operator.load(traction),
                    traction,
                    memory,
                    iterations=i,
                    assemblies=i,
                    newton_iterations=newton,
                    krylov_iterations=traction.iterations,
                )
            geometry = guess = new
        return Attempt(Result.COUPLING, None, iterations=i, assemblies=i)


@dataclass(frozen=True)
class StructureOnly:
    """No fluid: one structure solve a step, the enclosed volume as only load."""

    def init(self) -> Memory:
        return {}

    def reset(self, memory: Memory) -> Memory:
        return memory

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt:
        step = problem.structure.step(problem.state, None, problem.dt, problem.volume)
        problem.report(1, 0.0, 1.0, step.ok)
        if not step.ok:
            return Attempt(Result.NEWTON, None, iterations=1)
        newton = step.newton_iterations
        return Attempt(None, step, memory=memory, iterations=1, newton_iterations=newton)
