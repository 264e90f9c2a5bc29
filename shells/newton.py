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
    """

    x: np.ndarray
    multiplier: float
    outcome: Outcome
    history: tuple[float, ...]


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
    system: Callable[[np.ndarray, float], tuple],
    x: np.ndarray,
    multiplier: float = 0.0,
    *,
    tolerance: float,
    max_iterations: int = 25,
) -> NewtonResult:
    """Solve ``r(x, lam) = 0, g(x) = 0``.

    Parameters
    ----------
    system : callable
        ``system(x, lam)`` returns residual (n,), tangent (sparse or dense), constraint gradient
        q (n,) or None, and constraint defect g.
    x : (n,) array
        Start.
    tolerance : float
        Stop when the largest update falls below it (one more quadratic step is then free).
    max_iterations : int

    Returns
    -------
    NewtonResult
    """
    x, history = x.copy(), []
    for _ in range(max_iterations):
        residual, tangent, q, g = system(x, multiplier)
        if not np.all(np.isfinite(residual)):
            return NewtonResult(x, multiplier, Outcome.DIVERGED, tuple(history))
        try:
            solver = factorize(tangent)
        except (RuntimeError, np.linalg.LinAlgError, ValueError):
            return NewtonResult(x, multiplier, Outcome.SINGULAR, tuple(history))
        if q is None:
            dx = solver(-residual)
        else:
            y = solver(np.stack([-residual, q], axis=1))
            step = (g + q @ y[:, 0]) / (q @ y[:, 1])
            dx = y[:, 0] - step * y[:, 1]
            multiplier += step
        x += dx
        history.append(float(np.abs(dx).max()))
        if not np.isfinite(history[-1]) or history[-1] > 1e3 * max(history[0], tolerance):
            return NewtonResult(x, multiplier, Outcome.DIVERGED, tuple(history))
        if history[-1] <= tolerance:
            return NewtonResult(x, multiplier, Outcome.CONVERGED, tuple(history))
    return NewtonResult(x, multiplier, Outcome.LIMIT, tuple(history))
