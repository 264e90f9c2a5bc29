"""Local elements: functions against their definition, lattices that tile, rules that are exact."""

from math import factorial

import numpy as np
import pytest

from shells.surfaces.local_elements import functions, lattice, rule, triangle_exponents


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("derivative", [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_derivatives(shape: str, degree: int, derivative: tuple[int, int]) -> None:
    xi, eta, h = np.array([0.2, 0.5, 0.1]), np.array([0.3, 0.4, 0.05]), 1e-3
    i, j = derivative
    step = (h, 0.0) if i else (0.0, h)
    lower = (i - 1, j) if i else (i, j - 1)
    ahead, behind = (
        functions(shape, degree, xi + s * step[0], eta + s * step[1], lower) for s in (1, -1)
    )
    exact = functions(shape, degree, xi, eta, derivative)
    assert np.abs((ahead - behind) / (2 * h) - exact).max() < 1e-4


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_partition_of_unity(shape: str) -> None:
    table = functions(shape, 3, np.array([0.0, 0.3, 1.0]), np.array([1.0, 0.2, 0.0]))
    assert np.allclose(table.sum(axis=1), 1.0, atol=1e-15)
    assert np.allclose(table[[0, 2]].max(axis=1), 1.0)  # corners belong to one function


@pytest.mark.parametrize(("shape", "area"), [("triangle", 0.5), ("quadrilateral", 1.0)])
def test_lattices_tile(shape: str, area: float) -> None:
    xi, eta, cells = lattice(shape, 4)
    x, y = xi[cells], eta[cells]
    twice = sum(
        x[:, k] * np.roll(y, -1, axis=1)[:, k] - y[:, k] * np.roll(x, -1, axis=1)[:, k]
        for k in range(cells.shape[1])
    )
    assert np.allclose(twice, twice[0])
    assert twice[0] > 0.0
    assert np.isclose(0.5 * twice.sum(), area)


def test_rules_are_exact() -> None:
    xi, eta, weights = rule("triangle", 3)
    for _, b, c in triangle_exponents(4):
        exact = factorial(b) * factorial(c) / factorial(b + c + 2)
        assert np.isclose(weights @ (xi**b * eta**c), exact, rtol=1e-14)
