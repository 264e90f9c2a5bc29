"""Sparse factorisation whose every solution is checked: a wrong factor must not go unnoticed.

The matrix comes in its order of elimination. Pivots are taken on the diagonal where they are not
tiny; should a residual be too large, the solution is refined, then the matrix factorised again
with free pivots, and at last the solve fails loudly.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

RESIDUAL = 1e-9  # relative; refinement goes far below it
REFINEMENTS = 3


class LinearSolveError(ArithmeticError):
    """No factorisation gave an acceptable residual."""


class Factor:
    """LU factors of a matrix in elimination order.

    Attributes
    ----------
    residual : float
        Largest relative residual of the solutions so far.
    fill : int
        Nonzeros of both factors.
    """

    def __init__(self, matrix: csc_array):
        self._matrix = matrix
        self._lu = _careful(matrix)
        self._pivoted = False
        self.residual = 0.0

    @property
    def fill(self) -> int:
        return self._lu.nnz

    def solve(self, b: np.ndarray, transposed: bool = False) -> np.ndarray:
        """Solution for a right-hand side ``(n,)``.

        Raises
        ------
        LinearSolveError
            The residual stays above `RESIDUAL` even with free pivots.
        """
        matrix = self._matrix.T if transposed else self._matrix
        size = float(np.linalg.norm(b))
        if size == 0.0:
            return np.zeros_like(b)
        x, error = self._refined(matrix, b, size, transposed)
        if not error <= RESIDUAL and not self._pivoted:
            self._lu, self._pivoted = splu(self._matrix), True
            x, error = self._refined(matrix, b, size, transposed)
        if not error <= RESIDUAL:
            raise LinearSolveError(f"relative residual {error:.1e} with free pivots")
        self.residual = max(self.residual, error)
        return x

    def _refined(
        self, matrix: csc_array, b: np.ndarray, size: float, transposed: bool
    ) -> tuple[np.ndarray, float]:
        way = "T" if transposed else "N"
        x = self._lu.solve(b, way)
        r = b - matrix @ x
        error = np.linalg.norm(r) / size
        for _ in range(REFINEMENTS):
            if error <= 1e-3 * RESIDUAL or not np.isfinite(error):
                break
            x = x + self._lu.solve(r, way)
            r = b - matrix @ x
            error = np.linalg.norm(r) / size
        return x, float(error)


def _careful(matrix: csc_array) -> SuperLU:
    """Factors in the given order, or with free pivots where a pivot vanishes."""
    try:
        return splu(
            matrix,
            permc_spec="NATURAL",
            diag_pivot_thresh=1e-3,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        return splu(matrix)
