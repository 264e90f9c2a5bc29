"""Newton-Krylov update against the dense bordered system."""

import numpy as np
import pytest
from scipy.sparse import diags

from shells.equilibrium.damped_tangent import DampedFactor, FrozenDamping
from shells.equilibrium.newton import factorize


@pytest.mark.parametrize("constrained", [False, True])
def test_update_equals_the_dense_solution(constrained):
    rng = np.random.default_rng(0)
    n = 40
    K = diags([np.full(n - 1, -1.0), np.full(n, 2.5), np.full(n - 1, -1.0)], [-1, 0, 1]).tocsc()
    F = rng.standard_normal((n, 4))
    D = 1e3 * F @ F.T + 1e-2 * rng.standard_normal((n, n))  # stiff in four modes, not symmetric
    r, q, g = rng.standard_normal(n), rng.standard_normal(n), 0.3
    factor = DampedFactor(K, FrozenDamping(lambda x: D @ x), factorize, 1e-10)
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
    factor = DampedFactor(K, FrozenDamping(lambda x: D @ x), factorize, 1e-12, max_iterations=3)
    with pytest.raises(RuntimeError, match="stalled"):
        factor.bordered(np.ones(30), None, 0.0)


def test_systems_of_one_newton_iteration_share_solves_and_a_factor():
    """K and q change a little, D stays: a second system needs less than half of the first."""
    rng = np.random.default_rng(1)
    n, solves, factors = 60, [], []
    K = diags([np.full(n - 1, -1.0), np.full(n, 2.5), np.full(n - 1, -1.0)], [-1, 0, 1]).tocsc()
    F, q = rng.standard_normal((n, 8)), rng.standard_normal(n)
    damping = FrozenDamping(lambda x: solves.append(1) or 1e2 * (F @ (F.T @ x)))

    def counted(matrix):
        factors.append(1)
        return factorize(matrix)

    counts = []
    for change in (0.0, 1e-4):
        r, before = rng.standard_normal(n), len(solves)
        system = (1.0 + change) * K, damping, counted, 1e-8
        x, step = DampedFactor(*system).bordered(r, q + change, 0.3)
        assert (q + change) @ x == pytest.approx(-0.3, rel=1e-10)
        counts.append(len(solves) - before)
        left = (1.0 + change) * (K @ x) + damping.apply(x) + step * (q + change) + r
        assert np.linalg.norm(factorize(K)(left)) < 1e-6 * np.linalg.norm(x)
        before = len(solves)
        assert damping(x) == pytest.approx(1e2 * (F @ (F.T @ x)), abs=1e-9 * np.abs(r).max())
        assert len(solves) == before  # known from the solution
    assert len(factors) == 1
    assert counts[1] <= counts[0] // 2
