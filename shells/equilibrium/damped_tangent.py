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

Map = Callable[[np.ndarray], np.ndarray]


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

    solve: Map
    damping: Map
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
        along = None if q is None else self.solve(q)
        slope = 1.0 if q is None else float(q @ along)

        def precondition(b: np.ndarray, c: float) -> np.ndarray:
            y = self.solve(b)
            if q is None:
                return np.append(y, 0.0)
            step = (q @ y - c) / slope
            return np.append(y - step * along, step)

        def apply(z: np.ndarray) -> np.ndarray:
            return z + precondition(self.damping(z[:n]), 0.0)

        rhs = precondition(-residual, -g)
        operator = LinearOperator((n + 1, n + 1), matvec=apply, dtype=float)
        restart = min(self.max_iterations, n + 1)
        z, info = gmres(operator, rhs, rtol=self.tolerance, atol=0.0, restart=restart, maxiter=1)
        if info != 0 or not np.all(np.isfinite(z)):
            raise RuntimeError("GMRES on the damped tangent stalled")
        return z[:n], float(z[n])
