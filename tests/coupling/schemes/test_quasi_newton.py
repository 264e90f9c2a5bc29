"""IQN-ILS: exact on linear problems, filter, reuse, checkpoint round trip."""

import numpy as np
import pytest

from coupling.schemes.fixed_point import iterate
from coupling.schemes.quasi_newton import QuasiNewton, filter_columns


def linear(n, rho, seed=0):
    """x -> b - A x with eigenvalues of A spread up to rho."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.standard_normal((n, n)))
    A, b = q @ np.diag(np.geomspace(1.0, rho, n)) @ q.T, rng.standard_normal(n)
    return lambda x: b - A @ x, np.linalg.solve(np.eye(n) + A, b)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_exact_after_as_many_columns_as_unknowns(n):
    function, exact = linear(n, 200.0)
    x, evaluations, ok = iterate(
        function, np.zeros(n), QuasiNewton(filter=1e-10), tolerance=1e-8, max_iterations=40
    )
    assert ok
    assert x == pytest.approx(exact, abs=1e-8)
    assert evaluations <= n + 2  # one to start, n columns, one to confirm


def test_reused_columns_solve_the_next_problem_at_once():
    """The Jacobian of a shifted problem is the same: one update, one confirmation."""
    function, _ = linear(4, 50.0)
    scheme = QuasiNewton(filter=1e-10)
    x, memory = np.zeros(4), scheme.init()
    for _ in range(5):  # further ones would add columns of rounding
        x, memory = scheme.step(memory, x, function(x) - x)
    shifted = lambda y: function(y) + 1.0  # noqa: E731
    again = scheme.unpack(scheme.pack(scheme.next_step(memory)))
    _, evaluations, ok = iterate(
        shifted, x, scheme, tolerance=1e-7, max_iterations=20, memory=again
    )
    assert ok
    assert evaluations <= 2
    _, fresh, _ = iterate(shifted, x, scheme, tolerance=1e-7, max_iterations=20)
    assert fresh > evaluations


def test_filter_keeps_the_newest_and_drops_the_dependent():
    a = np.array([[1.0, 0.0, 0.0], [1.0, 1e-4, 0.0], [0.0, 2.0, 0.0]]).T
    kept, q, upper = filter_columns(a, 1e-2)
    assert kept.tolist() == [0, 2]
    assert q @ upper == pytest.approx(a[:, kept], abs=1e-15)
    assert filter_columns(a[:, :1] * 1e-100, 1e-2)[0].tolist() == [0]


def test_columns_leave_after_the_steps_allowed():
    scheme, function = QuasiNewton(reuse=2), linear(5, 3.0)[0]
    memory, x = scheme.init(), np.zeros(5)
    for _ in range(3):
        x, memory = scheme.step(memory, x, function(x) - x)
    ages = []
    for _ in range(4):
        memory = scheme.next_step(memory)
        ages.append(memory.columns)
    assert ages == [2, 2, 0, 0]


def test_equal_residuals_make_no_column():
    scheme, x, r = QuasiNewton(), np.zeros(2), np.array([1.0, 0.0])
    _, memory = scheme.step(scheme.init(), x, r)
    x, memory = scheme.step(memory, x, r)
    assert memory.columns == 0
    assert np.all(np.isfinite(x))
