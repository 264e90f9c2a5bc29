"""Newton-Krylov update against the dense bordered system."""

import numpy as np
import pytest
from scipy.sparse import diags

from shells.equilibrium.damped_tangent import DampedFactor
from shells.equilibrium.newton import factorize


@pytest.mark.parametrize("constrained", [False, True])
def test_update_equals_the_dense_solution(constrained):
    rng = np.random.default_rng(0)
    n = 40
    K = diags([np.full(n - 1, -1.0), np.full(n, 2.5), np.full(n - 1, -1.0)], [-1, 0, 1]).tocsc()
    F = rng.standard_normal((n, 4))
    D = 1e3 * F @ F.T + 1e-2 * rng.standard_normal((n, n))  # stiff in four modes, not symmetric
    r, q, g = rng.standard_normal(n), rng.standard_normal(n), 0.3
    factor = DampedFactor(factorize(K), lambda x: D @ x, tolerance=1e-10)
    x, step = factor.bordered(r, q if constrained else None, g)
    full = np.zeros((n + 1, n + 1))
    full[:n, :n] = K.toarray() + D
    full[n, n] = 1.0
    rhs = np.append(-r, 0.0)
    if constrained:
        full[n], full[:, n], full[n, n] = np.append(q, 0.0), np.append(q, 0.0), 0.0
        rhs[n] = -g
    exact = np.linalg.solve(full, rhs)
    assert np.append(x, step) == pytest.approx(exact, abs=1e-7 * np.abs(exact).max())


def test_stall_is_an_error():
    K = diags([np.ones(30)], [0]).tocsc()
    D = np.diag(np.geomspace(1.0, 1e6, 30))
    factor = DampedFactor(factorize(K), lambda x: D @ x, tolerance=1e-12, max_iterations=3)
    with pytest.raises(RuntimeError, match="stalled"):
        factor.bordered(np.ones(30), None, 0.0)
