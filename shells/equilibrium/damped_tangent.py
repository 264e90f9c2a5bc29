"""Tangents with a linear damping known by its action only: Newton-Krylov on the bordered system.

``[K + D, q; q^T 0] [dx; dlam] = [-r; -g]`` with sparse K, solved by GMRES preconditioned from the
left by the bordered factor of K: one structure back-solve and one D (a frozen fluid solve) an
iteration. Iterations go like the number of eigenvalues of K^-1 D above 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from .newton import Solve

Bordered = Callable[[np.ndarray, float], np.ndarray]


@dataclass(frozen=True)
class DampedFactor:
    """Solver for one Newton iteration.

    Parameters
    ----------
    solve : callable
        Solves with the sparse part K of the tangent.
    damping : callable
        Applies D to free coordinates (n,).
    tolerance : float
        Relative preconditioned residual. Newton's iteration contracts at least that fast, and
        its last update carries this relative error.
    max_iterations : int
    """

    solve: Solve
    damping: Solve
    tolerance: float = 1e-3
    max_iterations: int = 200

    def bordered(
        self, residual: np.ndarray, q: np.ndarray | None, g: float
    ) -> tuple[np.ndarray, float]:
        """Updates of x and of the multiplier.

        Raises
        ------
        RuntimeError
            GMRES stalled; Newton's iteration then ends as singular.
        """
        n = residual.size
        precondition = self._solve_free() if q is None else self._solve_under(q)

        def apply(z: np.ndarray) -> np.ndarray:
            return z + precondition(self.damping(z[:n]), 0.0)

        rhs = precondition(-residual, -g)
        operator = LinearOperator((n + 1, n + 1), matvec=apply, dtype=float)
        restart = min(self.max_iterations, n + 1)
        z, info = gmres(operator, rhs, rtol=self.tolerance, atol=0.0, restart=restart, maxiter=1)
        if info != 0 or not np.all(np.isfinite(z)):
            raise RuntimeError("GMRES on the damped tangent stalled")
        return z[:n], float(z[n])

    def _solve_free(self) -> Bordered:
        """Inverse of K alone; the multiplier stays."""
        return lambda b, c: np.append(self.solve(b), 0.0)

    def _solve_under(self, q: np.ndarray) -> Bordered:
        """Inverse of K with the constraint's row and column q around it."""
        along = self.solve(q)
        slope = float(q @ along)

        def solve(b: np.ndarray, c: float) -> np.ndarray:
            y = self.solve(b)
            step = (q @ y - c) / slope
            return np.append(y - step * along, step)

        return solve
