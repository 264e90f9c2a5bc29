"""Newton's method with one volume constraint, eliminated by block elimination.

Each iteration factors the tangent once and solves for two right-hand sides,
``A y = [-r, q]``, then ``dlam = (g + q.y_r) / (q.y_q)``: the dense volume row never enters the
sparse factor. Convention: L = W + lam (Q - V), so the excess pressure is p = -lam [T thm 14].
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
import scipy.linalg
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

Matrix: TypeAlias = csr_matrix | np.ndarray
Solve = Callable[[np.ndarray], np.ndarray]
LinearSolver = Callable[[Matrix], Solve]

# Iterations with a kept factor that one assembly and factorization with its own quadratic
# convergence is worth: residual and back-solve cost an eighth to a quarter of them.
CHORDS = 4


class NewtonOutcome(enum.Enum):
    """How an iteration ended; the value says it in words."""

    CONVERGED = "converged"
    DIVERGED = "the residual became infinite or grew beyond recovery"
    LIMIT = "the iteration limit was reached before the tolerance"
    SINGULAR = "the tangent is singular: a rigid motion is free or the shell is unstressed"
    BLOCKED = "contact stops every way after less than a hundredth of it"
    NO_EQUILIBRIUM = "the loads exceed a limit point: the shell yields ever more as it stretches"


@dataclass(frozen=True)
class NewtonResult:
    """Solution of the constrained system.

    Attributes
    ----------
    x : (n,) array
    multiplier : float
        lam; the excess pressure is ``-lam``.
    outcome : NewtonOutcome
    history : tuple of float
        Largest update of each iteration.
    residual : float
        Norm of the last residual seen over that of the first.
    factorizations : int
    """

    x: np.ndarray
    multiplier: float
    outcome: NewtonOutcome
    history: tuple[float, ...]
    residual: float = np.inf
    factorizations: int = 0


@dataclass(frozen=True)
class Equations:
    """The system at one iterate.

    Attributes
    ----------
    residual : (n,) array
    tangent : (n, n) sparse or dense matrix, or None
        None where only the residual was asked for.
    row : (n,) array or None
        Gradient q of the constraint, if there is one.
    defect : float
        Value g of the constraint.
    touching : bool
        Whether contact forces act.
    """

    residual: np.ndarray
    tangent: Matrix | None
    row: np.ndarray | None = None
    defect: float = 0.0
    touching: bool = False


class TangentFactor(Protocol):
    """A factored tangent K that solves with the constraint's row and column around it."""

    def bordered(
        self, residual: np.ndarray, q: np.ndarray | None, g: float
    ) -> tuple[np.ndarray, float]:
        """Updates of x and of the multiplier: ``[K, q; q^T, 0] [dx; dlam] = [-r; -g]``."""


@dataclass(frozen=True)
class BlockElimination:
    """The constraint eliminated with a second right-hand side for ``solve``, the inverse of K."""

    solve: Solve

    def bordered(
        self, residual: np.ndarray, q: np.ndarray | None, g: float
    ) -> tuple[np.ndarray, float]:
        """Updates of x and of the multiplier."""
        if q is None:
            return self.solve(-residual), 0.0
        y = self.solve(np.stack([-residual, q], axis=1))
        step = (g + q @ y[:, 0]) / (q @ y[:, 1])
        return y[:, 0] - step * y[:, 1], step


def factorize(matrix: Matrix) -> Solve:
    """Direct solver of a sparse symmetric-pattern or dense matrix.

    Parameters
    ----------
    matrix : (n, n) sparse matrix or array

    Returns
    -------
    callable
        ``solve(b)`` for b of shape (n,) or (n, k).

    Raises
    ------
    RuntimeError, numpy.linalg.LinAlgError
        If the matrix is exactly singular.
    """
    if not isinstance(matrix, np.ndarray):
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
    system: Callable[[np.ndarray, float, bool], Equations],
    x: np.ndarray,
    multiplier: float,
    factor: Callable[[Matrix], TangentFactor],
    *,
    tolerance: float,
    max_iterations: int,
    reuse: float,
    reach: float = np.inf,
) -> NewtonResult:
    """Solve ``r(x, lam) = 0, g(x) = 0``.

    Parameters
    ----------
    system : callable
        ``system(x, lam, with_tangent)`` returns the `Equations` at an iterate; the tangent may
        be left out where it is not wanted.
    x : (n,) array
        Start.
    multiplier : float
        Start of lam.
    factor : callable
        Factors a tangent.
    tolerance : float
        Stop when the largest update falls below it (one more quadratic step is then free).
    max_iterations : int
    reuse : float
        Keep a factor while each update that it gives is below this fraction of the one before,
        and so far below that `CHORDS` more meet the tolerance; an update that is not is thrown
        away, for that of a new factor. 0 factors every tangent.
    reach : float
        An update beyond it is beyond recovery: over a vanishing stiffness, or of a huge load.

    Returns
    -------
    NewtonResult
    """
    x, count = x.copy(), 0
    history: list[float] = []
    norms: list[float] = []
    factored: TangentFactor | None = None

    def ended(outcome: NewtonOutcome) -> NewtonResult:
        residual = norms[-1] / norms[0] if norms and norms[0] > 0.0 else 0.0
        return NewtonResult(x, multiplier, outcome, tuple(history), residual, count)

    for _ in range(max_iterations):
        kept = reuse > 0.0 and factored is not None
        at = system(x, multiplier, not kept)
        norms.append(float(np.linalg.norm(at.residual)))
        if not np.isfinite(norms[-1]):
            return ended(NewtonOutcome.DIVERGED)
        try:
            if kept and factored is not None:
                dx, step = factored.bordered(at.residual, at.row, at.defect)
                kept = worth_keeping(_size(dx), history[-1], reuse, tolerance)
                at = at if kept or at.tangent is not None else system(x, multiplier, True)
            if not kept:
                factored, count = factor(at.tangent), count + 1
                dx, step = factored.bordered(at.residual, at.row, at.defect)
        except (RuntimeError, np.linalg.LinAlgError, ValueError):
            return ended(NewtonOutcome.SINGULAR)
        if _size(dx) > reach:
            return ended(beyond(at, dx, step))
        x += dx
        multiplier += step
        history.append(_size(dx))
        if not np.isfinite(history[-1]) or history[-1] > 1e3 * max(history[0], tolerance):
            return ended(NewtonOutcome.DIVERGED)
        if history[-1] <= tolerance:
            return ended(NewtonOutcome.CONVERGED)
    return ended(NewtonOutcome.LIMIT)


def beyond(at: Equations, dx: np.ndarray, step: float) -> NewtonOutcome:
    """What an enormous update means: rounding for a stiffness, or the answer to a huge load."""
    if at.tangent is None:
        return NewtonOutcome.DIVERGED
    forces = at.tangent @ dx
    left = forces + at.residual + (0.0 if at.row is None else step * at.row)
    solved = np.linalg.norm(left) <= 0.1 * np.linalg.norm(at.residual)
    stiffness = abs(float(dx @ forces)) / float(dx @ dx)
    stiff = stiffness > 1e-13 * float(np.abs(at.tangent.diagonal()).max())
    return NewtonOutcome.DIVERGED if solved and stiff else NewtonOutcome.SINGULAR


def _size(update: np.ndarray) -> float:
    return float(np.abs(update).max())


def worth_keeping(update: float, last: float, reuse: float, tolerance: float) -> bool:
    """Whether a kept factor's update contracts, and will meet the tolerance in a few more."""
    contraction = update / last
    return contraction < reuse and update * contraction**CHORDS <= tolerance
