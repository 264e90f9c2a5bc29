"""Newton's method for mixed flows: factors reused while they contract, damping, continuation.

A solve that does not converge says so; `solve_robustly` then tries Reynolds continuation at the
fixed partition and, after that, a start from the skew-symmetric form [T 7.13], which cannot feed
energy in at the interface. Convergence means the residual's round-off floor, since goals may be
tiny.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from .checked_factor import LinearSolveError
from .flow import MixedFlow

logger = logging.getLogger(__name__)

REUSE = 0.05  # a factor is reused while it reduces the residual at least by this
SHORTEST = 1.0 / 64.0
FLOOR = 1e-6  # of the tolerance: nothing is left to gain
LADDER = (10.0, 30.0, 100.0, 200.0, 400.0, 700.0, 1000.0, 1500.0)


class Newton(Enum):
    """How a solve ended."""

    CONVERGED = "converged"
    CONTINUATION = "converged after Reynolds continuation at the fixed partition"
    SKEW = "converged from the solution of the skew-symmetric form"
    STALLED = "Newton stalled: refine the mesh at the interface or lower the Reynolds number"
    LINEAR = "a linear system could not be solved to its tolerance"

    @property
    def ok(self) -> bool:
        """Whether there is a solution."""
        return self not in (Newton.STALLED, Newton.LINEAR)


@dataclass(frozen=True)
class Solution:
    """A field and how it was found.

    Parameters
    ----------
    x : (n,) array
    outcome : Newton
    residual : float
        Euclidean norm over the free unknowns.
    iterations, factorisations : int
    linear_residual : float
        Largest relative residual of the linear solves.
    """

    x: np.ndarray
    outcome: Newton
    residual: float
    iterations: int = 0
    factorisations: int = 0
    linear_residual: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether the field is a solution."""
        return self.outcome.ok


def solve(
    flow: MixedFlow,
    flagged: np.ndarray,
    start: np.ndarray | None = None,
    *,
    tolerance: float = 1e-10,
    max_iterations: int = 25,
) -> Solution:
    """Solve a mixed flow by Newton's method alone.

    Parameters
    ----------
    flow : MixedFlow
    flagged : (n_elements,) bool array
        Elements with convection.
    start : (n,) array, optional
        Initial guess; rest otherwise.
    tolerance : float
        Residual relative to that of rest, where the solve counts as converged; it then goes on
        with the last factor while that helps.
    max_iterations : int

    Returns
    -------
    Solution
        Its ``outcome`` says whether it converged.
    """
    fixed = np.where(flow.fixed, flow.values, 0.0)
    goal = tolerance * float(np.linalg.norm(flow.free_residual(fixed, flow.nowhere)))
    x = fixed if start is None else np.where(flow.fixed, flow.values, start)
    r = flow.free_residual(x, flagged)
    size, factor, made, worst = float(np.linalg.norm(r)), None, 0, 0.0
    for k in range(max_iterations):
        done = size <= goal
        if size <= FLOOR * goal:
            break
        try:
            fresh = factor is None
            factor = factor or flow.tangent(x, flagged)
            made += fresh
            step = flow.extend(factor.solve(r))
        except LinearSolveError as error:
            logger.warning("Newton iteration %d: %s", k, error)
            return Solution(x, Newton.LINEAR, size, k, made, worst)
        worst = max(worst, factor.residual)
        new, r_new, size_new = _line_search(flow, flagged, x, step, size, damped=fresh and not done)
        if done and size_new >= 0.5 * size:
            break  # round-off floor
        if size_new >= size and fresh:
            return Solution(x, Newton.STALLED, size, k, made, worst)
        if size_new > REUSE * size and not done:
            factor = None
        if size_new < size:
            x, r, size = new, r_new, size_new
    outcome = Newton.CONVERGED if size <= goal else Newton.STALLED
    return Solution(x, outcome, size, k, made, worst)


def _line_search(
    flow: MixedFlow,
    flagged: np.ndarray,
    x: np.ndarray,
    step: np.ndarray,
    size: float,
    damped: bool,
) -> tuple[np.ndarray, np.ndarray, float]:
    """The first of the halved steps that reduces the residual, or the shortest."""
    t = 1.0
    while True:
        new = x + t * step
        r = flow.free_residual(new, flagged)
        size_new = float(np.linalg.norm(r))
        if not damped or size_new < (1.0 - 1e-4 * t) * size or t <= SHORTEST:
            return new, r, size_new
        t *= 0.5


def continuation(
    flow: MixedFlow, flagged: np.ndarray, ladder: Sequence[float] = LADDER
) -> Solution:
    """Solve at rising Reynolds numbers, each from the one before.

    Parameters
    ----------
    flow : MixedFlow
    flagged : (n_elements,) bool array
        Elements with convection.
    ladder : sequence of float
        Reynolds numbers on the way to that of the flow.

    Returns
    -------
    Solution
        Of the last Reynolds number, or of the first that did not converge.
    """
    start, iterations, made = None, 0, 0
    rungs = [re for re in ladder if re < 0.99 * flow.reynolds]
    for reynolds in [*rungs, flow.reynolds]:
        found = solve(flow.at(reynolds), flagged, start)
        start, iterations = found.x, iterations + found.iterations
        made += found.factorisations
        if not found.ok:
            break
    return replace(found, iterations=iterations, factorisations=made)


def solve_robustly(
    flow: MixedFlow, flagged: np.ndarray, start: np.ndarray | None = None
) -> Solution:
    """Solve with continuation and a start from the skew-symmetric form where Newton stalls.

    Parameters
    ----------
    flow : MixedFlow
    flagged : (n_elements,) bool array
        Elements with convection.
    start : (n,) array, optional
        Initial guess; rest otherwise.

    Returns
    -------
    Solution
        Its ``outcome`` names what worked.
    """
    linear = flow.convection.wind is not None or not flagged.any()
    direct = linear or start is not None or flow.reynolds <= 2.0 * LADDER[0]
    tries = []
    if direct:
        tries.append((Newton.CONVERGED, lambda: solve(flow, flagged, start)))
    label = Newton.CONTINUATION if direct else Newton.CONVERGED
    tries.append((label, lambda: continuation(flow, flagged)))
    tries.append((Newton.SKEW, lambda: _from_skew(flow, flagged)))
    iterations, made = 0, 0
    for label, attempt in tries:
        found = attempt()
        iterations, made = iterations + found.iterations, made + found.factorisations
        if found.ok:
            return replace(found, outcome=label, iterations=iterations, factorisations=made)
        logger.warning("%s; residual %.1e", found.outcome.value, found.residual)
    return replace(found, iterations=iterations, factorisations=made)


def _from_skew(flow: MixedFlow, flagged: np.ndarray) -> Solution:
    found = continuation(flow.skew(), flagged)
    return solve(flow, flagged, found.x) if found.ok else found
