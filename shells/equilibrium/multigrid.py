"""Algebraic multigrid for very large tangents: smoothed aggregation on the rigid motions.

Conjugate gradients with pyamg's hierarchy; for definite tangents only. The direct factor
`shells.equilibrium.newton.factorize` is faster up to a few hundred thousand unknowns and has no
such limit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import cg

from ..conditions.rigid_motions import rigid_modes


def multigrid(
    points: np.ndarray,
    extraction: csr_matrix,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 2000,
) -> Callable[[csr_matrix], Callable[[np.ndarray], np.ndarray]]:
    """Linear solver for `ShellStructure(solver=...)`.

    Parameters
    ----------
    points : (n_full, 3) array
        Coefficients of a configuration: its rigid motions are the near-null space.
    extraction : (3 n_full, n_free) sparse matrix
    tolerance : float
        Relative residual of the conjugate gradients.

    Returns
    -------
    callable
        ``solver(matrix)`` sets the hierarchy up and returns ``solve(b)``, which raises
        RuntimeError where the iteration stops short (an indefinite tangent).
    """
    import pyamg

    modes = extraction.T @ rigid_modes(points)

    def solver(matrix: Any) -> Callable[[np.ndarray], np.ndarray]:
        hierarchy = pyamg.smoothed_aggregation_solver(csr_matrix(matrix), B=modes, max_coarse=200)
        inverse = hierarchy.aspreconditioner()

        def solve(b: np.ndarray) -> np.ndarray:
            columns = []
            for column in b.reshape(b.shape[0], -1).T:
                x, failed = cg(matrix, column, rtol=tolerance, maxiter=max_iterations, M=inverse)
                if failed:
                    raise RuntimeError("conjugate gradients stopped short: indefinite tangent")
                columns.append(x)
            return np.stack(columns, axis=1).reshape(b.shape)

        return solve

    return solver
