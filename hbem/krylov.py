"""Solvers of the saddle system ``[A c; c^T 0] [tau; zeta] = [F; 0]`` of a single layer.

Dense LU for small systems; otherwise full GMRES, preconditioned from the right by the mass
matrix, so that the residual it watches is the true one. The constraint is scaled by
``kappa = <1, A 1> / <1, M 1>``, the size of A in units of the mass matrix: counts and residuals
then do not depend on the units of length.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import spmatrix
from scipy.sparse.linalg import LinearOperator, gmres, splu

DENSE_LIMIT = 6000  # unknowns up to which LU is the simplest robust solver


class KrylovResult(enum.Enum):
    """How a linear solve ended; the value explains itself."""

    DIRECT = "solved by dense LU factors"
    CONVERGED = "the true residual is below the tolerance"
    ITERATIONS = "the residual is above the tolerance after all iterations; allow more"

    @property
    def ok(self) -> bool:
        return self is not KrylovResult.ITERATIONS


@dataclass(frozen=True)
class SaddleSolution:
    """Solution of a saddle system.

    Attributes
    ----------
    solution : (3 n,) or (3 n, k) array
    zeta : float or (k,) array
        Multiplier of the constraint.
    result : KrylovResult
    iterations : int
    residual : float
        True relative residual of the whole system.
    history : tuple of float
        Relative residual after each iteration.
    """

    solution: np.ndarray
    zeta: np.ndarray | float
    result: KrylovResult
    iterations: int
    residual: float
    history: tuple[float, ...] = ()


@dataclass(frozen=True)
class DenseSaddle:
    """Saddle system with LU factors.

    Parameters
    ----------
    operator : LinearOperator
        ``(3 n, 3 n)`` with a method ``dense()``.
    constraint : (n, 3) array
    mass : (n, n) sparse matrix
        Scalar mass matrix.
    """

    operator: LinearOperator
    constraint: np.ndarray
    mass: spmatrix

    @cached_property
    def _matrix(self) -> np.ndarray:
        n = self.operator.shape[0]
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = self.operator.dense()
        matrix[:n, n] = matrix[n, :n] = self.constraint.ravel() * self._scale
        return matrix

    @cached_property
    def _scale(self) -> float:
        return strength(self.operator, self.mass)

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray]:
        return lu_factor(self._matrix, check_finite=False)

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side ``(3 n,)`` or several ``(3 n, k)``."""
        full = np.concatenate([rhs, np.zeros((1, *rhs.shape[1:]))])
        x = lu_solve(self._factors, full, check_finite=False)
        residual = _relative(self._matrix @ x - full, full)
        zeta = x[-1] * self._scale
        return SaddleSolution(x[:-1], zeta, KrylovResult.DIRECT, 0, residual)


@dataclass(frozen=True)
class IterativeSaddle:
    """Saddle system solved by GMRES with the mass matrix as preconditioner.

    Parameters
    ----------
    operator, constraint, mass :
        As for `DenseSaddle`; the operator needs no ``dense()``.
    tolerance : float
        Relative residual.
    max_iterations : int
    """

    operator: LinearOperator
    constraint: np.ndarray
    mass: spmatrix
    tolerance: float = 1e-8
    max_iterations: int = 400

    @cached_property
    def _scale(self) -> float:
        return strength(self.operator, self.mass)

    @cached_property
    def _mass_factor(self):
        return splu(self.mass.tocsc())

    @cached_property
    def _schur(self) -> float:
        return float(np.sum(self.constraint * self._mass_factor.solve(self.constraint)))

    def _apply(self, x: np.ndarray) -> np.ndarray:
        c = self._scale * self.constraint.ravel()
        return np.append(self.operator @ x[:-1] + c * x[-1], c @ x[:-1])

    def _precondition(self, y: np.ndarray) -> np.ndarray:
        tau = self._mass_factor.solve(y[:-1].reshape(-1, 3)) / self._scale
        return np.append(tau.ravel(), y[-1] / (self._scale * self._schur))

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side ``(3 n,)``."""
        full = np.append(rhs, 0.0)
        n, history = full.size, []
        outer = LinearOperator((n, n), lambda y: self._apply(self._precondition(y)), dtype=float)
        y, _ = gmres(
            outer,
            full,
            rtol=0.5 * self.tolerance,
            atol=0.0,
            restart=min(n, self.max_iterations),
            maxiter=1,
            callback=lambda r: history.append(float(r)),
            callback_type="pr_norm",
        )
        x = self._precondition(y)
        residual = _relative(self._apply(x) - full, full)
        ended = KrylovResult.CONVERGED if residual <= self.tolerance else KrylovResult.ITERATIONS
        return SaddleSolution(
            x[:-1], x[-1] * self._scale, ended, len(history), residual, tuple(history)
        )


def saddle(
    operator: LinearOperator,
    constraint: np.ndarray,
    mass: spmatrix,
    *,
    dense_limit: int = DENSE_LIMIT,
    tolerance: float = 1e-8,
    max_iterations: int = 400,
) -> DenseSaddle | IterativeSaddle:
    """The solver that suits the size: LU up to ``dense_limit`` unknowns, else GMRES."""
    if operator.shape[0] <= dense_limit and hasattr(operator, "dense"):
        return DenseSaddle(operator, constraint, mass)
    return IterativeSaddle(operator, constraint, mass, tolerance, max_iterations)


def strength(operator: LinearOperator, mass: spmatrix) -> float:
    """``<1, A 1> / <1, M 1>`` for a constant density: the size of A against the mass matrix."""
    one = np.zeros((mass.shape[0], 3))
    one[:, 0] = 1.0
    return float(one.ravel() @ (operator @ one.ravel()) / mass.sum())


def _relative(difference: np.ndarray, reference: np.ndarray) -> float:
    size = np.linalg.norm(reference)
    return float(np.linalg.norm(difference) / size) if size > 0.0 else 0.0
