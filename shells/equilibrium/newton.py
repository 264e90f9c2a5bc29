"""Newton's method with one volume constraint, eliminated by block elimination.

Each iteration factors the tangent once and solves for two right-hand sides,
``A y = [-r, q]``, then ``dlam = (g + q.y_r) / (q.y_q)``: the dense volume row never enters the
sparse factor. Convention: L = W + lam (Q - V), so the excess pressure is p = -lam [T thm 14].
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse import issparse
from scipy.sparse.linalg import splu


class Outcome(enum.Enum):
    """How an iteration ended."""

    CONVERGED = "converged"
    DIVERGED = "the residual became infinite or grew beyond recovery"
    LIMIT = "the iteration limit was reached before the tolerance"
    SINGULAR = "the tangent is singular: a rigid motion is free or the shell is unstressed"


@dataclass(frozen=True)
class NewtonResult:
    """Solution of the constrained system.

    Attributes
    ----------
    x : (n,) array
    multiplier : float
        lam; the excess pressure is ``-lam``.
    outcome : Outcome
    history : tuple of float
        Largest update of each iteration.
    residual : float
        Norm of the last residual seen over that of the first.
    factorizations : int
    """

    x: np.ndarray
    multiplier: float
    outcome: Outcome
    history: tuple[float, ...]
    residual: float = np.inf
    factorizations: int = 0


def factorize(matrix: object) -> Callable[[np.ndarray], np.ndarray]:
    """Direct solver of a sparse symmetric-pattern or dense matrix.

    Raises
    ------
    RuntimeError, numpy.linalg.LinAlgError
        If the matrix is exactly singular.
    """
    if issparse(matrix):
        lu = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.01,
            options={"SymmetricMode": True},
        )
        return lu.solve
    factors = scipy.linalg.lu_factor(matrix, check_finite=True)
    return lambda b: scipy.linalg.lu_solve(factors, b)


def solve(
    system: Callable[..., tuple],
    x: np.ndarray,
    multiplier: float = 0.0,
    *,
    tolerance: float,
    max_iterations: int = 25,
    solver: Callable[[object], Callable] = factorize,
    reuse: float = 0.0,
) -> NewtonResult:
    """Solve ``r(x, lam) = 0, g(x) = 0``.

    Parameters
    ----------
    system : callable
        ``system(x, lam)`` returns residual (n,), tangent (sparse or dense), constraint gradient
        q (n,) or None, and constraint defect g. With ``reuse`` it is also called as
        ``system(x, lam, False)`` and may then leave the tangent out.
    x : (n,) array
        Start.
    tolerance : float
        Stop when the largest update falls below it (one more quadratic step is then free).
    max_iterations : int
    solver : callable
        ``solver(matrix)`` returns a function that solves with the matrix.
    reuse : float
        Keep a factor as long as each update is below this fraction of the one before (chord
        iteration); 0 factors every tangent.

    Returns
    -------
    NewtonResult
    """
    x, history, norms, count, solve_with = x.copy(), [], [], 0, None

    def ended(outcome: Outcome) -> NewtonResult:
        residual = norms[-1] / norms[0] if norms and norms[0] > 0.0 else 0.0
        return NewtonResult(x, multiplier, outcome, tuple(history), residual, count)

    for _ in range(max_iterations):
        keep = solve_with is not None and len(history) > 1 and history[-1] < reuse * history[-2]
        keep |= reuse > 0.0 and len(history) == 1
        residual, tangent, q, g = system(x, multiplier, False) if keep else system(x, multiplier)
        norms.append(float(np.linalg.norm(residual)))
        if not np.isfinite(norms[-1]):
            return ended(Outcome.DIVERGED)
        try:
            if not keep:
                solve_with, count = solver(tangent), count + 1
            dx, step = _update(solve_with, residual, q, g)
        except (RuntimeError, np.linalg.LinAlgError, ValueError):
            return ended(Outcome.SINGULAR)
        x += dx
        multiplier += step
        history.append(float(np.abs(dx).max()))
        if not np.isfinite(history[-1]) or history[-1] > 1e3 * max(history[0], tolerance):
            return ended(Outcome.DIVERGED)
        if history[-1] <= tolerance:
            return ended(Outcome.CONVERGED)
    return ended(Outcome.LIMIT)


def _update(
    solve_with: Callable, residual: np.ndarray, q: np.ndarray | None, g: float
) -> tuple[np.ndarray, float]:
    """Updates of x and of the multiplier by block elimination, or by the solver's own way."""
    if hasattr(solve_with, "bordered"):
        return solve_with.bordered(residual, q, g)
    if q is None:
        return solve_with(-residual), 0.0
    y = solve_with(np.stack([-residual, q], axis=1))
    step = (g + q @ y[:, 0]) / (q @ y[:, 1])
    return y[:, 0] - step * y[:, 1], step
