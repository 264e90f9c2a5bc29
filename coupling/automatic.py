"""Choice of the scheme by rho = m dt S, and change to the robust one when a step fails.

Below ``limit`` the cheap partitioned scheme needs no more assemblies than the implicit one and
no response. A failed step is tried again at the same dt by the robust scheme, which then stays
for ``rest`` steps; the a-priori rho has just been proven wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .attempt import Attempt, Memory, Scheme, StepProblem
from .protocols import Result

FAILURES = (Result.COUPLING, Result.NEWTON)


@dataclass(frozen=True)
class Automatic:
    """Two schemes and the rule between them.

    Parameters
    ----------
    rate : float
        rho / dt, measured or a priori.
    cheap, robust : Scheme
    limit : float
        The cheap scheme is tried where ``rate dt`` is below.
    rest : int
        Steps the robust scheme stays after the cheap one failed.
    """

    rate: float
    cheap: Scheme
    robust: Scheme
    limit: float = 0.3
    rest: int = 20

    def init(self) -> Memory:
        return {**_prefixed("cheap", self.cheap.init()), "rest": np.array(0)}

    def reset(self, memory: Memory) -> Memory:
        cheap = self.cheap.reset(_stripped("cheap", memory))
        return {**_prefixed("cheap", cheap), "rest": memory["rest"]}

    def attempt(self, problem: StepProblem, memory: Memory) -> Attempt:
        rest, rho = int(memory["rest"]), self.rate * problem.dt
        if rho >= self.limit or rest > 0:
            return self._robust(problem, memory, max(rest - 1, 0))
        tried = self.cheap.attempt(problem, _stripped("cheap", memory))
        if tried.cause not in FAILURES:
            kept = {**_prefixed("cheap", tried.memory), "rest": np.array(0)}
            return replace(tried, memory=kept)
        note = (
            f"changed to the robust scheme for {self.rest} steps: {tried.cause.name} "
            f"although rho = {rho:.2g} < {self.limit:g}"
        )
        second = self._robust(problem, self.reset(memory), self.rest)
        return replace(
            second,
            iterations=second.iterations + tried.iterations,
            assemblies=second.assemblies + tried.assemblies,
            newton_iterations=second.newton_iterations + tried.newton_iterations,
            krylov_iterations=second.krylov_iterations + tried.krylov_iterations,
            notes=(note, *second.notes),
        )

    def _robust(self, problem: StepProblem, memory: Memory, rest: int) -> Attempt:
        attempt = self.robust.attempt(problem, {})
        # loads of the cheap scheme would be extrapolated across the steps in between
        fresh = {**_prefixed("cheap", self.cheap.init()), "rest": np.array(rest)}
        return replace(attempt, memory=fresh)


def _prefixed(name: str, memory: Memory) -> dict[str, np.ndarray]:
    return {f"{name}.{key}": value for key, value in memory.items()}


def _stripped(name: str, memory: Memory) -> dict[str, np.ndarray]:
    start = f"{name}."
    return {key[len(start) :]: v for key, v in memory.items() if key.startswith(start)}
