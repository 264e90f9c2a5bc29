"""Contraction before and measured: film of Reynolds, worst mode, the true subiteration."""

import numpy as np
import pytest
from scipy.sparse.linalg import aslinearoperator

from cases.benchmarks.coupling import suite as bench
from coupling.schemes.contraction import film_symbol, measure_contraction, worst_mode


def test_film_of_constant_thickness():
    """``24 / (k^2 H^3)`` with half a wave over the film."""
    s = np.linspace(0.0, 3.0, 200)
    exact = 24.0 / ((np.pi / 3.0) ** 2 * 0.2**3)
    assert film_symbol(s, np.full(200, 0.2)) == pytest.approx(exact, rel=1e-4)


def test_film_is_ruled_by_its_narrow_part():
    """A wide middle leaves two films, closed at one end and open at the other."""
    s = np.linspace(0.0, 4.0, 401)
    wide = np.abs(s - 2.0) < 1.0
    narrow = 24.0 / ((np.pi / 2.0) ** 2 * 0.1**3)  # k = pi / (2 l), l = 1
    assert film_symbol(s, np.where(wide, 5.0, 0.1)) == pytest.approx(narrow, rel=0.03)


def test_worst_mode_of_a_known_operator():
    values = np.array([0.1, -3.0, 2.0, 0.5, 0.3])
    response, inverse = aslinearoperator(np.diag(values)), aslinearoperator(np.eye(5))
    rho, mode = worst_mode(response, inverse, 0.5)
    assert rho == pytest.approx(6.0, rel=1e-6)
    assert abs(mode[1]) == pytest.approx(1.0, abs=1e-6)
    assert measure_contraction(response, inverse, 0.5) == rho


@pytest.mark.parametrize("dt", [0.06, 8.0])
def test_contraction_of_the_planar_pancake(dt):
    """Spectral radius = residual ratio in the antisymmetric mode; the formula within 10%."""
    state = bench.states(bench.PLANE, [], (0.0,))[0]
    row = bench.contraction_row(bench.PLANE, [], state, 0.005, dt)
    assert row["error"] < 1e-3
    assert row["antisymmetric"] > 0.99
    assert row["a priori / radius"] == pytest.approx(1.0, abs=0.1)
