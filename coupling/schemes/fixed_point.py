"""Partitioned subiterations in the order of [T tab. 5.1]: structure first, then fluid.

The first structure solve uses the load extrapolated from the last two steps; afterwards each
subiteration assembles the fluid on the relaxed configuration x_k, solves the structure under that
load and compares its output with x_k. Contraction is rho = m dt S: plain iteration needs
rho < 1, Aitken works to about 20, IQN-ILS to about 200.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exchange import Result
from .relaxation import M, Relaxation
from .scheme import Memory, Scheme, StepProblem, StepResult


def iterate(
    function: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    relaxation: Relaxation[M],
    *,
    tolerance: float,
    max_iterations: int,
    memory: M | None = None,
) -> tuple[np.ndarray, int, bool]:
    """Solve ``x = function(x)``: the bare iteration, without structure and fluid.

    Parameters
    ----------
    function : callable
    x : array
        First iterate.
    relaxation : Relaxation
    tolerance : float
        Norm of ``function(x) - x`` at which the iteration stops.
    max_iterations : int
    memory : optional
        The relaxation's memory to start with; default its `init`.

    Returns
    -------
    array
        Last iterate.
    int
        Evaluations of the function.
    bool
        Whether the tolerance was met.
    """
    memory = relaxation.init() if memory is None else memory
    for k in range(1, max_iterations + 1):
        residual = function(x) - x
        if not np.all(np.isfinite(residual)):
            return x, k, False
        if np.linalg.norm(residual) <= tolerance:
            return x, k, True
        x, memory = relaxation.step(memory, x, residual)
    return x, max_iterations, False


def _extrapolated(memory: Memory, dt: float) -> np.ndarray | None:
    """Load extrapolated linearly in time from the last two steps."""
    if "load" not in memory:
        return None
    if "load_before" not in memory:
        return memory["load"]
    ratio = dt / float(memory["dt"])
    return memory["load"] + ratio * (memory["load"] - memory["load_before"])


@dataclass(frozen=True)
class Partitioned(Scheme):
    """Subiterations between structure and fluid, relaxed or accelerated.

    Parameters
    ----------
    relaxation : Relaxation
        `GaussSeidel`, `Constant`, `Aitken` or `QuasiNewton`.
    """

    relaxation: Relaxation[Any]  # its memory passes through unseen, packed as arrays

    def init(self) -> Memory:
        return self.relaxation.pack(self.relaxation.init())

    def reset(self, memory: Memory) -> Memory:
        loads = {k: v for k, v in memory.items() if k in ("load", "load_before", "dt")}
        return {**loads, **self.init()}

    def attempt(self, problem: StepProblem, memory: Memory) -> StepResult:
        state, dt = problem.state, problem.dt
        load = _extrapolated(memory, dt)
        step = problem.structure.step(state, load, dt, problem.volume)
        newton, krylov = step.newton_iterations, 0
        carried = self.relaxation.next_step(self.relaxation.unpack(memory))
        x = new = step.state.coefficients
        for k in range(1, problem.max_iterations + 1):
            x, failure = problem.reachable(x, new) if step.ok else (x, Result.NEWTON)
            if failure is not None:
                return StepResult(failure, None, iterations=k, assemblies=k - 1)
            operator = problem.assemble(x)
            traction = operator.traction((x - state.coefficients) / dt)
            krylov += traction.iterations
            load = operator.load(traction)
            step = problem.structure.step(state, load, dt, problem.volume, guess=x)
            newton += step.newton_iterations
            if not step.ok:
                return StepResult(Result.NEWTON, None, iterations=k, assemblies=k)
            new = step.state.coefficients
            done, size = problem.converged(new - x, new)
            x, carried = self.relaxation.step(carried, x, new - x)
            problem.report(k, size, carried.factor, done)
            if done:
                new_memory = {**self.relaxation.pack(carried), "load": load, "dt": np.array(dt)}
                if "load" in memory:
                    new_memory["load_before"] = memory["load"]
                return StepResult(None, step, load, traction, new_memory, k, k, newton, krylov)
        return StepResult(Result.COUPLING, None, iterations=k, assemblies=k)
