"""The front door with two fluids: exact flows about a sphere for every viscosity ratio."""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.bodies import sphere
from hbem import StokesFlow

E = np.diag([1.0, -0.5, -0.5])
AXIS = np.array([0.0, 0.0, 1.0])


def norm(flow: StokesFlow, values: np.ndarray) -> float:
    return float(np.sqrt(flow.weights @ np.sum(values**2, axis=1)))


def outside(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and pressure (unit viscosity) about a sphere whose surface moves as ``E x``."""
    r = np.linalg.norm(x, axis=1)[:, None]
    n = x / r
    along = np.sum((n @ E) * n, axis=1)[:, None]
    velocity = (n @ E) / r**4 + 2.5 * n * along * (r**-2 - r**-4)
    return velocity, (5.0 * along / r**3)[:, 0]


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 3.0])
def test_straining_sphere(ratio):
    """Jump ``(2 + 3 lambda) E x``; measured errors 3.3e-3, those of the best approximation."""
    flow = StokesFlow(sphere(8, 8), viscosity=2.0, viscosity_ratio=ratio, measure="none")
    found = flow.traction(lambda x: x @ E)
    exact = 2.0 * (2.0 + 3.0 * ratio) * (flow.points @ E)
    assert norm(flow, found.values - exact) < 4e-3 * norm(flow, exact)
    assert (flow.formulation.double is None) == (ratio == 1.0)  # no double layer unless needed


@pytest.mark.parametrize("ratio", [0.3, 3.0])
def test_drag_is_that_of_the_outer_fluid(ratio):
    """Measured: 2.2e-6 off, the quadrature of the default rules."""
    flow = StokesFlow(sphere(8, 8), viscosity=2.0, viscosity_ratio=ratio, measure="none")
    force = flow.traction(AXIS).force()[0]
    np.testing.assert_allclose(force, 12.0 * np.pi * ratio * AXIS, rtol=5e-6, atol=1e-8)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
def test_field_of_a_straining_sphere(ratio):
    """Measured: velocity 2.5e-3, stress and pressure 2e-2 of the wall's pressure jump."""
    flow = StokesFlow(sphere(8, 8), viscosity=2.0, viscosity_ratio=ratio, measure="none")
    d = np.random.default_rng(1).normal(size=(20, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    inner, outer = 0.9 * d, np.concatenate([1.01 * d, 2.0 * d])
    field = flow.traction(lambda x: x @ E).field(np.concatenate([inner, outer]))
    assert np.array_equal(field.inside, np.arange(60) < 20)
    assert np.abs(field.velocity[:20] - inner @ E).max() < 5e-3
    velocity, pressure = outside(outer)
    assert np.abs(field.velocity[20:] - velocity).max() < 5e-3
    assert np.abs(field.stress[:20] - 4.0 * E).max() < 0.1 * max(1.0, ratio)
    assert np.abs(field.pressure[20:] - 2.0 * ratio * pressure).max() < 0.1 * max(1.0, ratio)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("stream", [AXIS, lambda x: np.tile(AXIS, (len(x), 1))])
def test_sphere_held_in_a_stream(ratio, stream):
    """Stokes drag with the sign of the stream, the fluid inside at rest, the stream far away."""
    flow = StokesFlow(sphere(8, 8), viscosity_ratio=ratio, background=stream, measure="none")
    held = flow.traction(np.zeros(3))
    force = held.force()[0]
    np.testing.assert_allclose(force, -6.0 * np.pi * ratio * AXIS, rtol=5e-6, atol=1e-8)
    field = held.field([[0.2, 0.1, -0.3], [0.0, 0.0, 1e4], [0.0, 0.0, 2.0]])
    assert np.abs(field.velocity[0]).max() < 1e-4
    np.testing.assert_allclose(field.velocity[1], AXIS, rtol=0, atol=2e-4)
    beside = 1.0 - 1.5 / 2.0 + 0.5 / 8.0  # on the axis: 1 - 3/(2 r) + 1/(2 r^3)
    np.testing.assert_allclose(field.velocity[2], beside * AXIS, rtol=0, atol=3e-4)


def test_a_body_moving_with_the_stream_feels_nothing():
    flow = StokesFlow(sphere(5, 6), viscosity_ratio=3.0, background=AXIS)
    found = flow.traction(AXIS)
    assert np.abs(found.values).max() < 1e-3
    assert found.field([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]).velocity == pytest.approx(
        np.tile(AXIS, (2, 1)), abs=1e-3
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"viscosity_ratio": -1.0}, "not negative"),
        ({"viscosity_ratio": np.inf}, "finite"),
        ({"viscosity_ratio": 0.0, "background": AXIS}, "no outer fluid"),
        ({"background": np.zeros((7, 3))}, "background: expected"),
    ],
)
def test_wrong_fluids_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        StokesFlow(sphere(4, 5), **change)
