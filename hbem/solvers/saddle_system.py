"""The saddle system ``[A C; C^T 0] [tau; zeta] = [F; 0]`` of a single layer, and its solution.

One column of C and one multiplier for each closed component: its pressure is free, ``V n = 0``.
The constraint is scaled by ``kappa = <1, A 1> / <1, M 1>``, the size of A in units of the mass
matrix: counts and residuals then do not depend on the units of length.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import spmatrix
from scipy.sparse.linalg import LinearOperator, SuperLU, splu

from .gmres import KrylovResult

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

    def defect(self, residual: np.ndarray, density: np.ndarray) -> np.ndarray:
        """Right-hand side of a correction: a residual, and the constraint's of a density."""
        return np.concatenate([residual, -(self.columns.T @ density)])

    def multiplied(self, zeta: np.ndarray | float) -> np.ndarray:
        """``C zeta`` of the unscaled constraint, ``(3 n,)``."""
        return self.columns @ (np.atleast_1d(zeta) / self.scale)

    def split(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray | float]:
        """Density and multipliers, a float for a single one."""
        zeta = x[self.n :] * self.scale
        if zeta.shape[0] > 1:
            return x[: self.n], zeta
        return x[: self.n], zeta[0] if x.ndim > 1 else float(zeta[0])


def strength(operator: LinearOperator, mass: spmatrix) -> float:
    """``<1, A 1> / <1, M 1>`` for a constant density: the size of A against the mass matrix."""
    one = np.zeros((mass.shape[0], 3))
    one[:, 0] = 1.0
    return float(one.ravel() @ (operator @ one.ravel()) / mass.sum())


@dataclass(frozen=True)
class MassPreconditioner:
    """``M^-1 / kappa`` on densities, its Schur complement on multipliers: for fat bodies.

    Parameters
    ----------
    system : SaddleSystem
    """

    system: SaddleSystem

    @cached_property
    def _factor(self) -> SuperLU:
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
