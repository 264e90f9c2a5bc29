"""Solvers of the saddle system of a single layer, see `saddle_system`.

Dense LU for small systems; otherwise GMRES on the true residual, preconditioned by the mass matrix
(fat bodies) or two-level Schwarz (gaps).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import spmatrix
from scipy.sparse.linalg import LinearOperator

from .gmres import KrylovResult, gmres
from .saddle_system import (
    Builder,
    MassPreconditioner,
    Preconditioner,
    SaddleSolution,
    SaddleSystem,
)

DENSE_LIMIT = 6000  # unknowns up to which LU is the simplest robust solver


@dataclass(frozen=True)
class DenseSaddle:
    """Saddle system with LU factors.

    Parameters
    ----------
    operator : LinearOperator
        ``(3 n, 3 n)`` with a method ``dense()``.
    constraint : (n, 3) array
        ``c_a = int N_a n``.
    mass : (n, n) sparse matrix
        Scalar mass matrix.
    components : (n,) int array, optional
        Closed component of each density function; default one.
    """

    operator: LinearOperator
    constraint: np.ndarray
    mass: spmatrix
    components: np.ndarray | None = None

    @cached_property
    def system(self) -> SaddleSystem:
        """The scaled system."""
        return SaddleSystem(self.operator, self.constraint, self.mass, self.components)

    @cached_property
    def _matrix(self) -> np.ndarray:
        n, size = self.system.n, self.system.size
        matrix = np.zeros((size, size))
        matrix[:n, :n] = self.operator.dense()
        matrix[:n, n:] = self.system.columns
        matrix[n:, :n] = self.system.columns.T
        return matrix

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray]:
        return lu_factor(self._matrix, check_finite=False)

    def prepare(self) -> None:
        """Factorise, which the first solve does otherwise."""
        _ = self._factors

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side or several.

        Parameters
        ----------
        rhs : (3 n,) or (3 n, k) array

        Returns
        -------
        SaddleSolution
        """
        full = self.system.extend(rhs)
        x = lu_solve(self._factors, full, check_finite=False)
        residual = _relative(self._matrix @ x - full, full)
        return SaddleSolution(*self.system.split(x), KrylovResult.DIRECT, 0, residual)

    def density(self, rhs: np.ndarray) -> np.ndarray:
        """The density alone, ``(3 n,)`` or ``(3 n, k)``: the residual would double the cost."""
        return lu_solve(self._factors, self.system.extend(rhs), check_finite=False)[: self.system.n]

    def approximate(self, v: np.ndarray) -> np.ndarray:
        """The scaled system's inverse on ``(size,)``: what `IterativeSaddle` has roughly."""
        return lu_solve(self._factors, v, check_finite=False)

    def correction(
        self, residual: np.ndarray, density: np.ndarray, tolerance: float
    ) -> SaddleSolution:
        """Solve for what is missing of a density; see `IterativeSaddle.correction`."""
        full = self.system.defect(residual, density)
        x = lu_solve(self._factors, full, check_finite=False)
        return SaddleSolution(*self.system.split(x), KrylovResult.DIRECT, 0, 0.0)


@dataclass(frozen=True)
class IterativeSaddle:
    """Saddle system solved by GMRES.

    Parameters
    ----------
    operator : LinearOperator
        ``(3 n, 3 n)``.
    constraint : (n, 3) array
        ``c_a = int N_a n``.
    mass : (n, n) sparse matrix
        Scalar mass matrix.
    tolerance : float
        True relative residual.
    max_iterations : int
    components : (n,) int array, optional
        Closed component of each density function; default one.
    preconditioner : callable
        Builds a preconditioner ``(size,)`` to ``(size,)`` from a `SaddleSystem`.
    """

    operator: LinearOperator
    constraint: np.ndarray
    mass: spmatrix
    tolerance: float = 1e-8
    max_iterations: int = 400
    components: np.ndarray | None = None
    preconditioner: Builder = MassPreconditioner

    @cached_property
    def system(self) -> SaddleSystem:
        """The scaled system."""
        return SaddleSystem(self.operator, self.constraint, self.mass, self.components)

    @cached_property
    def _precondition(self) -> Preconditioner:
        return self.preconditioner(self.system)

    def approximate(self, v: np.ndarray) -> np.ndarray:
        """The preconditioner, a rough inverse of the scaled system, on ``(size,)``."""
        return self._precondition(v)

    def prepare(self) -> None:
        """Build the preconditioner, which the first solve does otherwise."""
        _ = self._precondition

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side.

        Parameters
        ----------
        rhs : (3 n,) array

        Returns
        -------
        SaddleSolution
        """
        return self._solve(self.system.extend(rhs), self.tolerance)

    def correction(
        self, residual: np.ndarray, density: np.ndarray, tolerance: float
    ) -> SaddleSolution:
        """Solve for what is missing of a density, with the residual of another operator.

        Parameters
        ----------
        residual : (3 n,) array
            Of the first rows, multipliers included.
        density : (3 n,) array
            Whose constraint may be violated.
        tolerance : float
            Relative residual of the correction.

        Returns
        -------
        SaddleSolution
        """
        return self._solve(self.system.defect(residual, density), tolerance)

    def _solve(self, full: np.ndarray, tolerance: float) -> SaddleSolution:
        found = gmres(
            self.system.apply,
            self._precondition,
            full,
            tolerance=tolerance,
            max_iterations=self.max_iterations,
        )
        split = self.system.split(found.x)
        count = len(found.history)
        return SaddleSolution(*split, found.result, count, found.residual, found.history)


def saddle(
    operator: LinearOperator,
    constraint: np.ndarray,
    mass: spmatrix,
    *,
    components: np.ndarray | None = None,
    dense_limit: int = DENSE_LIMIT,
    tolerance: float = 1e-8,
    max_iterations: int = 400,
    preconditioner: Builder = MassPreconditioner,
) -> DenseSaddle | IterativeSaddle:
    """The solver that suits the size: LU up to ``dense_limit`` unknowns, else GMRES.

    Parameters
    ----------
    operator : LinearOperator
        ``(3 n, 3 n)``; for LU with a method ``dense()``.
    constraint : (n, 3) array
        ``c_a = int N_a n``.
    mass : (n, n) sparse matrix
        Scalar mass matrix.
    components : (n,) int array, optional
        Closed component of each density function; default one.
    dense_limit : int
        Largest number of unknowns for LU.
    tolerance, max_iterations, preconditioner
        Of GMRES, see `IterativeSaddle`.

    Returns
    -------
    DenseSaddle or IterativeSaddle
    """
    if operator.shape[0] <= dense_limit and hasattr(operator, "dense"):
        return DenseSaddle(operator, constraint, mass, components)
    return IterativeSaddle(
        operator, constraint, mass, tolerance, max_iterations, components, preconditioner
    )


def _relative(difference: np.ndarray, reference: np.ndarray) -> float:
    size = np.linalg.norm(reference)
    return float(np.linalg.norm(difference) / size) if size > 0.0 else 0.0
