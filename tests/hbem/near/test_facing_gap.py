"""The closest distance of facing walls is that of the surfaces, whatever the samples see."""

from dataclasses import replace

import numpy as np
import pytest

from cases.benchmarks.integrals.gaps import disc
from cases.geometry.bodies import sphere, spheroid
from cases.geometry.pillows.pillow import round_bag
from hbem.flows.stokes_flow import StokesFlow
from hbem.near.facing_gap import FacingGap, closest_facing
from hbem.surfaces.patches import BezierPatches, union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

TURN = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
TURN = TURN * np.linalg.det(TURN)
OBLIQUE = np.array([0.6, 0.48, 0.64])


def moved(body: BezierPatches, shift: np.ndarray) -> BezierPatches:
    return replace(body, coefficients=body.coefficients @ TURN.T + shift)


def gap_of(*bodies: BezierPatches) -> FacingGap:
    body = union(*bodies)
    found = closest_facing(sample(body, body.coefficients, QuadratureOrders()))
    assert found is not None
    return found


@pytest.mark.parametrize("gap", [1.0, 1e-2, 1e-5])
@pytest.mark.parametrize("direction", [OBLIQUE, TURN[:, 2]], ids=["elements", "pole"])
def test_two_spheres(gap, direction):
    """Samples of 6 x 6 elements are up to a thousand times farther apart."""
    found = gap_of(moved(sphere(6, 6), 0.0), moved(sphere(6, 6), (2.0 + gap) * direction))
    assert found.distance == pytest.approx(gap, rel=1e-5)
    assert found.curvature_radius == pytest.approx(0.5, rel=2e-3)
    np.testing.assert_allclose(found.points[1] - found.points[0], gap * direction, atol=1e-7)
    np.testing.assert_allclose(found.normals, [direction, -direction], atol=2e-2)
    assert np.all((found.element_size > 0.5) & (found.element_size < 1.1))


def test_spheres_of_different_size_and_inside_each_other():
    outside = gap_of(sphere(8, 8), moved(sphere(8, 8, radius=0.25), 1.26 * OBLIQUE))
    assert outside.distance == pytest.approx(0.01, rel=1e-6)
    assert outside.curvature_radius == pytest.approx(0.2, rel=1e-3)
    concentric = gap_of(sphere(8, 8), sphere(8, 8, radius=1.25))
    assert concentric.distance == pytest.approx(0.25, rel=1e-7)
    eccentric = gap_of(sphere(8, 8), moved(sphere(8, 8, radius=1.25), 0.2 * OBLIQUE))
    assert eccentric.distance == pytest.approx(0.05, rel=1e-6)
    assert eccentric.curvature_radius == pytest.approx(5.0, rel=1e-2)


def test_two_sheets_of_one_bag():
    """Their common rim does not count, though the sheets meet there."""
    found = gap_of(disc(14, 10, 0.0))
    assert found.distance == pytest.approx(0.1, rel=2e-3)
    bag = round_bag(20, gap=0.01)
    smooth = closest_facing(sample(bag.patches(), bag.coefficients, QuadratureOrders()))
    assert smooth.distance == pytest.approx(0.018, rel=0.15)
    assert np.abs(smooth.points[:, 2]).min() > 0.007


def test_a_convex_body_has_no_facing_walls_worth_a_name():
    body = spheroid(8, 8, c=0.7)
    found = closest_facing(sample(body, body.coefficients, QuadratureOrders()))
    assert found is None or found.distance > 1.2


def test_spheres_graded_towards_the_contact():
    """Rows of half the film's length; closing speed 2: lubrication gives 53.42 times 6 pi."""
    gap, flip = 0.01, np.array([1.0, -1.0, -1.0])
    below = sphere(12, 6, pole_row=0.05)
    above = replace(below, coefficients=below.coefficients * flip + [0.0, 0.0, 2.0 + gap])
    pair = union(below, above)
    found = gap_of(pair)
    assert found.distance == pytest.approx(gap, rel=1e-6)
    assert np.all(found.element_size < found.film_length)
    flow = StokesFlow(pair, measure="none")
    closing = np.where(flow.points[:, 2:] > 1.0 + 0.5 * gap, -1.0, 1.0) * [0.0, 0.0, 1.0]
    force = flow.traction(closing).force()[:, 2] / (6.0 * np.pi)
    lubrication = 0.5 / gap - 0.45 * np.log(gap) + 1.346
    np.testing.assert_allclose(force, [lubrication, -lubrication], rtol=2e-3)
    with pytest.raises(ValueError, match="pole_row must lie in"):
        sphere(12, 6, pole_row=0.3)
