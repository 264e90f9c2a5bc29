"""Spline spaces: partition of unity, smoothness, reproduction, poles, restrictions."""

import numpy as np
import pytest

from shells.surfaces.membrane_rule import reduced_rule
from shells.surfaces.spline_surface import SplineSurface, pole_rings, ring_scale
from shells.surfaces.splines import SplineSpace

BREAKS = np.array([0.0, 1.0, 2.5, 3.0, 4.0, 5.0])


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("periodic", [False, True])
def test_functions_sum_to_one(degree, periodic):
    space = SplineSpace(BREAKS, degree, periodic, np.array([1, 1, 2, 1, 1, 1]))
    x = np.linspace(0.0, 5.0, 41)
    assert np.abs(space.evaluate(x).sum(axis=1) - 1.0).max() < 1e-14
    assert np.abs(space.evaluate(x, 1).sum(axis=1)).max() < 1e-13
    assert space.evaluate(x).min() > -1e-14


@pytest.mark.parametrize("degree", [2, 3])
def test_knot_multiplicity_sets_the_smoothness(degree):
    double = SplineSpace(BREAKS, degree, multiplicity=np.array([1, 1, 2, 1, 1, 1]))
    step = 1e-12
    for knot, m in ((1.0, 1), (2.5, 2)):
        for order in range(degree):
            jump = double.evaluate(knot + step, order) - double.evaluate(knot - step, order)
            continuous = order <= degree - m
            assert (np.abs(jump).max() < 1e-9) == continuous


def test_greville_points_reproduce_lines():
    space = SplineSpace(BREAKS, 3)
    x = np.linspace(0.0, 5.0, 23)
    assert np.abs(space.evaluate(x) @ space.greville - x).max() < 1e-14


def test_fit_reproduces_polynomials_and_holds_constraints():
    space = SplineSpace(BREAKS, 3)
    x = np.linspace(0.0, 5.0, 60)
    curve = np.stack([x**3 - x, 2.0 * x**2], axis=1)
    assert np.abs(space.evaluate(x) @ space.fit(curve, x) - curve).max() < 1e-10
    row = space.evaluate(np.array([0.0]))[0]
    held = space.fit(curve, x, [(row, np.array([1.5, np.nan]))])
    assert row @ held[:, 0] == pytest.approx(1.5, abs=1e-12)


def test_too_few_periodic_elements_are_refused():
    with pytest.raises(ValueError, match="at least 4"):
        SplineSpace(np.linspace(0.0, 1.0, 4), 3, periodic=True)


def test_pole_makes_a_tangent_plane():
    """Any values of the three pole dofs give rings 0 and 1 in one plane: C1 at the pole."""
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, 9), 3, periodic=True)
    corners = np.random.default_rng(1).standard_normal((3, 3))
    rings = pole_rings(t) @ corners
    assert np.abs(rings[: t.n] - corners.mean(axis=0)).max() < 1e-14
    spread = rings[t.n :] - rings[0]
    assert np.linalg.svd(spread, compute_uv=False)[2] < 1e-14


def test_spline_circle_radius():
    """Figures of the pancake study: mean radius .95524, deviation 2.1e-4 (p = 3, 12 elements)."""
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, 13), 3, periodic=True)
    assert ring_scale(t) == pytest.approx(0.95524, abs=1e-5)


def test_density_tables_partition_unity_on_poles_and_cuts():
    t = SplineSpace(np.linspace(0.0, 1.0, 9), 2, periodic=True)
    surface = SplineSurface(SplineSpace(BREAKS, 2), t, pole_start=True)
    for part in (surface, surface.restrict(np.arange(8, 24))):
        sums = np.add.reduceat(part.extraction, part.indptr[:-1], axis=0)
        assert np.abs(sums - 1.0).max() < 1e-14
        assert part.dofs.max() + 1 == part.n_dofs
    inner, outer = surface.restrict(np.arange(16)), surface.restrict(np.arange(16, 40))
    # functions across the rim are cut in two: p rings are doubled
    assert inner.n_coefficients + outer.n_coefficients == surface.n_coefficients + 2 * t.n


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("periodic", [False, True])
def test_reduced_rule_is_exact_with_few_points(degree, periodic):
    """Products of two functions of degree (p + 1) / 2 on 1.5 points an element."""
    space = SplineSpace(np.linspace(0.0, 5.0, 13) ** 1.1, degree, periodic)
    points, weights = reduced_rule(space)
    assert points.size <= 1.5 * space.n_elements + 2
    assert weights.min() > 0.0
    target = SplineSpace(space.breaks, degree + 1, periodic, np.full(13, 3))
    x, w = np.polynomial.legendre.leggauss(degree + 2)
    h = np.diff(space.breaks)
    fine = (space.breaks[:-1, None] + 0.5 * h[:, None] * (x + 1.0)).ravel()
    exact = (0.5 * h[:, None] * w).ravel() @ target.evaluate(fine)
    assert weights @ target.evaluate(points) == pytest.approx(exact, abs=1e-11)
