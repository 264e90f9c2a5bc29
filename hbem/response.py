"""The fluid's response on frozen geometry: velocity of the membrane to the load on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse.linalg import LinearOperator

from .solvers.saddle import DenseSaddle

if TYPE_CHECKING:
    from .flows.enclosed_operator import EnclosedOperator


class Response(LinearOperator):
    """The linear map ``load = R v`` (plus the drive) on interleaved coefficients ``3 a + i``."""

    def __init__(self, operator: EnclosedOperator):
        n = 3 * operator.model.patches.n_coefficients
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self._operator = operator

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        op = self._operator
        solved = op.solve(op.linear_data(np.asarray(x).reshape(-1, 3)))
        return op.force(solved.solution.reshape(-1, 3)).ravel()

    def dense(self) -> np.ndarray:
        """R as an array: one factorisation, one right-hand side a membrane velocity dof."""
        op = self._operator
        matrix = np.zeros(self.shape)
        moving = np.flatnonzero(np.diff(op.coupling.tocsc().indptr))
        columns = (3 * moving[:, None] + np.arange(3)).ravel()
        coupling = op.coupling[:, moving].toarray()
        data = np.einsum("ab,ik->aibk", coupling, np.eye(3)).reshape(-1, columns.size)
        influx = np.outer(op.influx_data.ravel(), op.flux_form[moving].ravel())
        tractions = self._solve(op.right_hand_side(data + influx)).reshape(coupling.shape[0], -1)
        load = -op.model.mass_ratio * (coupling.T @ tractions)
        matrix[np.ix_(columns, columns)] = load.reshape(columns.size, columns.size)
        return matrix

    def _solve(self, rhs: np.ndarray) -> np.ndarray:
        system = self._operator.system
        if isinstance(system, DenseSaddle):
            return system.solve(rhs).solution
        return np.stack([system.solve(column).solution for column in rhs.T], axis=1)
