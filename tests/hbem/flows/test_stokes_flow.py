"""The front door: closed surfaces, boundary velocity in, traction, forces and torques out."""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.bodies import closed_body, from_control_points, sphere
from cases.geometry.pillows.pillow import accordion, round_bag
from hbem import StokesFlow, SurfaceError
from hbem.surfaces.narrowest_gap import narrowest
from hbem.surfaces.patches import union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample


def test_drag_and_torque_of_a_sphere():
    """Measured: drag 2e-6, torque 2e-6 off."""
    flow = StokesFlow(sphere(8, 8), viscosity=2.0)
    pulled = flow.traction(np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(pulled.force(), [[0, 0, 12 * np.pi]], atol=1e-4)
    assert pulled.power() == pytest.approx(12 * np.pi, rel=1e-5)
    turned = flow.traction(lambda x: np.cross([0.0, 0.0, 1.0], x))
    np.testing.assert_allclose(turned.torque(), [[0, 0, 16 * np.pi]], atol=1e-3)
    about = turned.torque(about=[1.0, 0.0, 0.0])
    np.testing.assert_allclose(about, turned.torque(), atol=1e-10)  # no force, one torque
    assert abs(turned.flux()).max() < 1e-12


def test_two_spheres_far_apart_feel_each_other_as_point_forces():
    """Equal forces side by side: drag ratio 1 / (1 + 3 a / 4 d) to first order in a / d."""
    one, d = sphere(6, 6), 20.0
    both = union(one, one)
    c = np.concatenate([one.coefficients, one.coefficients + np.array([d, 0.0, 0.0])])
    force = StokesFlow(both, c, measure="none").traction(np.array([0.0, 0.0, 1.0])).force() / (
        6 * np.pi
    )
    np.testing.assert_allclose(force[:, 2], 1.0 / (1.0 + 0.75 / d), rtol=1e-3)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units_scale_exactly(scale):
    """Force grows as length times velocity."""
    body, u = sphere(5, 6), np.array([0.3, 0.0, 1.0])
    reference = StokesFlow(body, measure="none").traction(u).force()
    scaled = StokesFlow(body, scale * body.coefficients, measure="none").traction(u).force()
    np.testing.assert_allclose(scaled / scale, reference, rtol=1e-9, atol=1e-9)


def test_surfaces_from_callables_and_control_points():
    def egg(s, t):
        theta, phi = np.pi * s, 2.0 * np.pi * t
        r = np.sin(theta) * (1.0 + 0.2 * np.cos(theta))
        return np.stack([r * np.cos(phi), r * np.sin(phi), 1.3 * np.cos(theta)], axis=-1)

    exact = closed_body(egg, 10, 10)
    drag = StokesFlow(exact, measure="none").traction(np.array([0.0, 0.0, 1.0])).force()[0, 2]
    theta = np.pi * np.array([0.0, *((np.arange(12) + 0.5) / 12), 1.0])
    theta[1], theta[-2] = np.pi / 36, np.pi - np.pi / 36
    control = egg(*np.meshgrid(theta / np.pi, np.arange(14) / 14, indexing="ij"))
    control[[0, -1], :, :2] = 0.0  # sin(pi) is not quite zero
    spline = from_control_points(control)
    close = StokesFlow(spline, measure="none").traction(np.array([0.0, 0.0, 1.0])).force()[0, 2]
    assert abs(close / drag - 1.0) < 0.05  # control points lie outside their surface
    with pytest.raises(ValueError, match="must each be one point"):
        from_control_points(control[1:])
    with pytest.raises(ValueError, match="periodic"):
        closed_body(egg, 4, 4, ends="open")


def test_wrong_surfaces_and_velocities_are_refused():
    body = sphere(4, 5)
    with pytest.raises(SurfaceError, match="inwards"):
        StokesFlow(body, body.coefficients * np.array([1.0, 1.0, -1.0]))
    flow = StokesFlow(body)
    with pytest.raises(ValueError, match="expected finite velocities"):
        flow.traction(np.zeros((7, 3)))
    with pytest.raises(ValueError, match="velocity are not finite"):
        flow.traction(np.full(flow.points.shape, np.nan))
    with pytest.raises(ValueError, match="viscosity"):
        StokesFlow(body, viscosity=0.0)


@pytest.mark.parametrize(
    ("bag", "gap", "thinness"),
    [
        (round_bag(28, gap=0.05), 0.1, 0.051),
        (round_bag(28, gap=0.01), 0.02, 0.010),
        (accordion(60, 2), 0.4 / 30, 0.0126),
    ],
    ids=["flat .05", "flat .01", "fold n=2"],
)
def test_narrowest_gap_is_found(bag, gap, thinness):
    found = narrowest(sample(bag.patches(), bag.coefficients, QuadratureOrders()))
    assert found.distance == pytest.approx(gap, rel=0.02)
    assert found.thinness == pytest.approx(thinness, rel=0.03)


def test_a_gap_too_thin_for_the_tolerance_is_said(caplog):
    bag = round_bag(12, gap=0.005)
    flow = StokesFlow(bag.patches(), tolerance=1e-4, measure="none")
    assert "cannot be met" in flow.budget.warnings[0]
    assert "cannot be met" in caplog.text


@pytest.mark.parametrize("method", ["h2", "aca"])
def test_compressed_flow_agrees_with_dense(method):
    """Forced on a small thin bag; measured 6e-5 (h2), 3e-5 (aca) of the traction."""
    bag = round_bag(14, gap=0.1)
    dense = StokesFlow(bag.patches(), bag.coefficients, measure="operator")
    flow = StokesFlow(bag.patches(), bag.coefficients, compression=method, measure="operator")
    assert dense.compression is None
    assert "dense matrix, LU" in repr(dense)
    assert flow.compression.method == method
    assert f"{method} at" in repr(flow)
    assert "GMRES (schwarz)" in repr(flow)
    assert flow.orders.outer == flow.orders.source or method == "h2"

    def squeeze(x):
        return x * [1.0, 1.0, -2.0] + np.cross([0.0, 0.2, 1.0], x)

    exact, found = dense.traction(squeeze), flow.traction(squeeze)
    assert found.iterations > 0
    assert found.result.ok
    error = found.coefficients - exact.coefficients
    mass = dense.surface.mass
    size = np.sqrt(np.sum(exact.coefficients * (mass @ exact.coefficients)))
    assert np.sqrt(np.sum(error * (mass @ error))) < 1e-3 * size


def test_unknown_compression_is_refused():
    with pytest.raises(ValueError, match="'auto', 'dense', 'aca' or 'h2'"):
        StokesFlow(sphere(4, 5), compression="fmm")
