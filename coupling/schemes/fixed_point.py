"""Partitioned subiterations in the order of [T tab. 5.1]: structure first, then fluid.

The first structure solve uses the load extrapolated from the last two steps; afterwards each
subiteration assembles the fluid on the relaxed configuration x_k, solves the structure under that
load and compares its output with x_k. Contraction is rho = m dt S: plain iteration needs
rho < 1, Aitken works to about 20, IQN-ILS to about 200.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..protocols import Result
from . import relaxation as relax
from .scheme import Attempt, Memory, StepProblem


def iterate(
    function: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    relaxation: relax.Relaxation,
    *,
    tolerance: float,
    max_iterations: int,
    memory: relax.Memory | None = None,
) -> tuple[np.ndarray, int, bool]:
    """Solve ``x = function(x)``; returns the iterate, evaluations used and success.

    The bare iteration that `Partitioned` wraps with a structure and a fluid.
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
class Partitioned:
    """Gauss-Seidel, constant, Aitken or quasi-Newton subiterations, by the relaxation given."""

    relaxation: relax.Relaxation

    def init(self) -> Memory:
        return self.relaxation.pack(self.relaxation.init())

    def reset(self, memory: Memory) -> Memory:
        loads = {k: v for k, v in memory.items() if k in ("load", "load_before", "dt")}
        return {**loads, **self.init()}

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt:
        state, dt = problem.state, problem.dt
        load = _extrapolated(memory, dt)
        step = problem.structure.step(state, load, dt, problem.volume)
        newton, krylov = step.newton_iterations, 0
        carried = self.relaxation.next_step(self.relaxation.unpack(memory))
        x = step.state.coefficients
        for k in range(1, problem.max_iterations + 1):
            cause = problem.inspect(x) if step.ok else Result.NEWTON
            if cause is not None:
                return Attempt(cause, None, iterations=k, assemblies=k - 1)
            operator = problem.fluid.assemble(x)
            traction = operator.traction((x - state.coefficients) / dt)
            krylov += traction.iterations
            load = operator.load(traction)
            step = problem.structure.step(state, load, dt, problem.volume, guess=x)
            newton += step.newton_iterations
            if not step.ok:
                return Attempt(Result.NEWTON, None, iterations=k, assemblies=k)
            new = step.state.coefficients
            done, size = problem.converged(new - x, new)
            x, carried = self.relaxation.step(carried, x, new - x)
            problem.report(k, size, carried.factor, done)
            if done:
                kept = {**self.relaxation.pack(carried), "load": load, "dt": np.array(dt)}
                if "load" in memory:
                    kept["load_before"] = memory["load"]
                return Attempt(None, step, load, traction, kept, k, k, newton, krylov)
        return Attempt(Result.COUPLING, None, iterations=k, assemblies=k)
