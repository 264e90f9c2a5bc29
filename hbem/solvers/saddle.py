"""Solvers of the saddle system ``[A C; C^T 0] [tau; zeta] = [F; 0]`` of a single layer.

One column of C and one multiplier for each closed component: its pressure is free, ``V n = 0``.
Dense LU for small systems; otherwise GMRES on the true residual, preconditioned by the mass matrix
(fat bodies) or two-level Schwarz (gaps). The constraint is scaled by
``kappa = <1, A 1> / <1, M 1>``, the size of A in units of the mass matrix: counts and residuals
then do not depend on the units of length.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import spmatrix
from scipy.sparse.linalg import LinearOperator, splu

from .gmres import KrylovResult, gmres

logger = logging.getLogger(__name__)
FEW = 8  # right-hand sides whose true residual is taken
DENSE_LIMIT = 6000  # unknowns up to which LU is the simplest robust solver
Preconditioner = Callable[[np.ndarray], np.ndarray]
Builder = Callable[["SaddleSystem"], Preconditioner]


@dataclass(frozen=True)
class SaddleSolution:
    """Solution of a saddle system.

    Attributes
    ----------
    solution : (3 n,) or (3 n, k) array
    zeta : float, (m,) or (k,) array
        Multiplier of the constraint; one for each of m components.
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
class SaddleSystem:
    """The scaled saddle system as a linear map.

    Parameters
    ----------
    operator : LinearOperator
        ``(3 n, 3 n)``.
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

    @property
    def n(self) -> int:
        """Density unknowns; multipliers follow them."""
        return self.operator.shape[0]

    @cached_property
    def scale(self) -> float:
        return strength(self.operator, self.mass)

    @cached_property
    def columns(self) -> np.ndarray:
        """C scaled by kappa, ``(3 n, m)``."""
        labels = self.components
        labels = np.zeros(self.constraint.shape[0], int) if labels is None else labels
        found, index = np.unique(labels, return_inverse=True)
        columns = np.zeros((*self.constraint.shape, found.size))
        columns[np.arange(labels.size), :, index] = self.scale * self.constraint
        return columns.reshape(-1, found.size)

    @property
    def size(self) -> int:
        return self.n + self.columns.shape[1]

    def apply(self, x: np.ndarray) -> np.ndarray:
        """``S x`` for ``(size,)`` or ``(size, k)``."""
        top, bottom = x[: self.n], x[self.n :]
        return np.concatenate([self.operator @ top + self.columns @ bottom, self.columns.T @ top])

    def extend(self, rhs: np.ndarray) -> np.ndarray:
        """``[F; 0]``."""
        return np.concatenate([rhs, np.zeros((self.columns.shape[1], *rhs.shape[1:]))])

    def split(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray | float]:
        """Density and multipliers, a float for a single one."""
        zeta = x[self.n :] * self.scale
        if zeta.shape[0] > 1:
            return x[: self.n], zeta
        return x[: self.n], zeta[0] if x.ndim > 1 else float(zeta[0])


@dataclass(frozen=True)
class DenseSaddle:
    """Saddle system with LU factors; parameters as for `SaddleSystem`.

    The operator needs a method ``dense()``.
    """

    operator: LinearOperator
    constraint: np.ndarray
    mass: spmatrix
    components: np.ndarray | None = None

    @cached_property
    def system(self) -> SaddleSystem:
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

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side ``(3 n,)`` or several ``(3 n, k)``."""
        full = self.system.extend(rhs)
        x = lu_solve(self._factors, full, check_finite=False)
        # of many right-hand sides a few: the product would cost as much as the solve
        few = slice(None, None, max(1, full.shape[-1] // FEW)) if full.ndim > 1 else slice(None)
        residual = _relative(self._matrix @ x[..., few] - full[..., few], full[..., few])
        return SaddleSolution(*self.system.split(x), KrylovResult.DIRECT, 0, residual)


@dataclass(frozen=True)
class MassPreconditioner:
    """``M^-1 / kappa`` on densities, its Schur complement on multipliers: for fat bodies."""

    system: SaddleSystem

    @cached_property
    def _factor(self):
        return splu(self.system.mass.tocsc())

    @cached_property
    def _schur(self) -> np.ndarray:
        c = self.system.columns
        tau = self._factor.solve(c.reshape(-1, 3 * c.shape[1]))
        return np.sum(c * tau.reshape(c.shape), axis=0) / self.system.scale

    def __call__(self, v: np.ndarray) -> np.ndarray:
        n, kappa = self.system.n, self.system.scale
        tau = self._factor.solve(v[:n].reshape(-1, 3)) / kappa
        return np.concatenate([tau.ravel(), v[n:] / self._schur])


@dataclass(frozen=True)
class IterativeSaddle:
    """Saddle system solved by GMRES; parameters as for `SaddleSystem`, and:

    tolerance : float
        True relative residual.
    max_iterations : int
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
        return SaddleSystem(self.operator, self.constraint, self.mass, self.components)

    @cached_property
    def _precondition(self) -> Preconditioner:
        return self.preconditioner(self.system)

    def solve(self, rhs: np.ndarray) -> SaddleSolution:
        """Solve for one right-hand side ``(3 n,)``."""
        found = gmres(
            self.system.apply,
            self._precondition,
            self.system.extend(rhs),
            tolerance=self.tolerance,
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
    """The solver that suits the size: LU up to ``dense_limit`` unknowns, else GMRES."""
    if operator.shape[0] <= dense_limit and hasattr(operator, "dense"):
        return DenseSaddle(operator, constraint, mass, components)
    return IterativeSaddle(
        operator, constraint, mass, tolerance, max_iterations, components, preconditioner
    )


def strength(operator: LinearOperator, mass: spmatrix) -> float:
    """``<1, A 1> / <1, M 1>`` for a constant density: the size of A against the mass matrix."""
    one = np.zeros((mass.shape[0], 3))
    one[:, 0] = 1.0
    return float(one.ravel() @ (operator @ one.ravel()) / mass.sum())


def _relative(difference: np.ndarray, reference: np.ndarray) -> float:
    size = np.linalg.norm(reference)
    return float(np.linalg.norm(difference) / size) if size > 0.0 else 0.0
