"""Newton's iteration with factors that are kept, and dropped in time."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

import shells
from cases import loader
from cases.kinds.load_path.build import problem
from shells.equilibrium import newton


def counted(structure):
    """The structure with a solver that counts its factors."""
    factors = []

    def solver(matrix):
        factors.append(matrix.shape)
        return newton.factorize(matrix)

    structure.solver = solver
    return factors


def snapping_roof():
    """Sze, Liu and Lo's hinged cylindrical roof, 12.7 thick: it snaps under 2.2 of its 3 kN."""
    R, angle, half, h, nu = 2540.0, 0.1, 254.0, 12.7, 0.3
    s = shells.SplineSpace(np.linspace(-angle, angle, 7), 3)
    t = shells.SplineSpace(np.linspace(-half, half, 5), 3)
    roof, x = shells.SplineSurface(s, t), np.linspace(-angle, angle, 200)
    profile = s.fit(R * np.stack([np.sin(x), np.cos(x)], axis=1), x)
    c = np.array([[a, y, z] for a, z in profile for y in t.greville])
    material = shells.Material(h**2 / 12.0, 3102.75 * h / (1.0 - nu**2), nu)
    shell = shells.KirchhoffLove(shells.SurfaceBasis(roof, c), material)
    E = shells.supported(roof, *(shells.hinge(roof, "s", end) for end in (0, 1)))
    force = shells.point_load(roof, 0.0, 0.0, [0.0, 0.0, -3000.0])
    return shell, E, c, lambda f: f * force


def cantilever():
    posed = problem(loader.read("cantilever-shear"))
    return posed.shell, posed.structure.E, posed.start, posed.load


@pytest.mark.parametrize("case", [cantilever, snapping_roof])
def test_a_kept_factor_saves_factors_and_costs_few_iterations(case):
    """They were 1471 instead of 129 on the cantilever, with 581 factors instead of 129."""
    shell, E, c, load = case()
    paths, factors = [], []
    for reuse in (0.0, 0.5):
        structure = shells.ShellStructure(shell, E, reuse=reuse)
        factors.append(counted(structure))
        paths.append(shells.load_path(structure, c, load, np.arange(1, 16) / 15))
    fresh, kept = paths
    assert fresh.ok
    assert kept.ok
    moved = np.abs(fresh.state.coefficients - c).max()
    assert np.abs(kept.state.coefficients - fresh.state.coefficients).max() < 1e-7 * moved
    assert kept.newton_iterations <= 1.5 * fresh.newton_iterations
    assert len(factors[1]) < 0.75 * len(factors[0])


def test_a_factor_that_stops_contracting_is_replaced():
    """x^3 = 1 from 3: far away the tangent falls by 4/9 a step, near the root it stays."""

    def system(x, multiplier, with_tangent):
        tangent = csr_matrix([[3.0 * x[0] ** 2]]) if with_tangent else None
        return newton.Equations(x**3 - 1.0, tangent)

    def factor(matrix):
        return newton.BlockElimination(newton.factorize(matrix))

    results = [
        newton.solve(
            system, np.array([3.0]), 0.0, factor, tolerance=1e-10, max_iterations=30, reuse=reuse
        )
        for reuse in (0.0, 0.5)
    ]
    for result in results:
        assert result.outcome is newton.NewtonOutcome.CONVERGED
        assert result.x == pytest.approx([1.0], abs=1e-10)
    assert len(results[1].history) <= len(results[0].history) + 2
    assert results[1].factorizations < results[0].factorizations
