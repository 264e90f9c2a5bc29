"""The flow off the surface against exact flows about a sphere, close to the wall and far from it.

Measured on 8 x 8: velocity 4e-4 and stress 1e-2 of the wall's at any distance (those of the
densities, best approximation 3e-3), solid angle 2e-4.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from cases.geometry.bodies import sphere
from hbem.flows.field import flow_field
from hbem.flows.streamlines import streamlines
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

E = np.diag([1.0, -0.5, -0.5])
DISTANCES = (0.5, 0.1, 1e-2, 1e-3, 1e-4)


def sampled(n):
    body = sphere(n, n)
    return sample(body, body.coefficients, QuadratureOrders())


def projected(surface, values):
    return spsolve(surface.mass.tocsc(), surface.project(values))


def straining(x, ratio):
    """Velocity, pressure and traction jump about a sphere whose surface moves as ``E x``."""
    r = np.linalg.norm(x, axis=1)[:, None]
    n = x / r
    along = np.sum((n @ E) * n, axis=1)[:, None]
    outer = (n @ E) / r**4 + 2.5 * n * along * (r**-2 - r**-4)
    inside = r < 1.0
    pressure = np.where(inside, 0.0, 5.0 * ratio * along * r**-3)[:, 0]
    return np.where(inside, x @ E, outer), pressure


def points(seed=0, count=40):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    return np.concatenate([d * (1.0 + side * gap) for gap in DISTANCES for side in (-1.0, 1.0)])


@pytest.mark.parametrize("ratio", [1.0, 0.3, 3.0])
def test_straining_sphere_at_any_distance(ratio):
    surface, x = sampled(8), points()
    y = surface.outer.points
    flow = flow_field(
        surface,
        projected(surface, (2.0 + 3.0 * ratio) * (y @ E)),
        x,
        velocity=projected(surface, y @ E),
        viscosity_ratio=ratio,
    )
    velocity, pressure = straining(x, ratio)
    inside = np.linalg.norm(x, axis=1) < 1.0
    assert np.array_equal(flow.inside, inside)
    assert np.abs(flow.angle - inside).max() < 5e-4
    assert np.abs(flow.velocity - velocity).max() < 5e-3
    scale = 5.0 * max(1.0, ratio)
    assert np.abs(flow.pressure - pressure).max() < 3e-2 * scale
    assert np.abs(flow.stress[inside] - 2.0 * E).max() < 3e-2 * scale
    trace = np.trace(flow.stress, axis1=1, axis2=2)
    assert trace == pytest.approx(-3.0 * flow.pressure, abs=1e-9 * scale)


def test_errors_fall_with_the_mesh():
    errors = []
    for n in (6, 12):
        surface, x = sampled(n), points()
        tau = projected(surface, 5.0 * (surface.outer.points @ E))
        flow = flow_field(surface, tau, x)
        errors.append(np.abs(flow.velocity - straining(x, 1.0)[0]).max())
    assert errors[1] < errors[0] / 4.0


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_translation_outside(ratio):
    """Stokes' flow about a moving sphere, whose traction is in the space: quadrature alone."""
    surface, e = sampled(8), np.array([0.0, 0.0, 1.0])
    d = points(count=6)[:12]
    d /= np.linalg.norm(d, axis=1)[:, None]
    x = np.concatenate([d * (1.0 + gap) for gap in (1.0, 0.1, 1e-3)])
    tau = np.tile(1.5 * ratio * e, (surface.patches.n_dofs, 1))
    u = np.tile(e, (surface.patches.n_dofs, 1))
    flow = flow_field(surface, tau, x, velocity=u, viscosity_ratio=ratio)
    r = np.linalg.norm(x, axis=1, keepdims=True)
    along = x[:, 2:] * x / r**2
    exact = 0.75 * (e + along) / r + 0.25 * (e - 3.0 * along) / r**3
    assert not flow.inside.any()
    assert np.abs(flow.velocity - exact).max() < 3e-4
    assert np.abs(flow.pressure - 1.5 * ratio * x[:, 2] / r[:, 0] ** 3).max() < 3e-3 * ratio


def test_interior_alone_has_no_outside():
    surface, x = sampled(6), points()
    y = surface.outer.points
    flow = flow_field(
        surface,
        projected(surface, 2.0 * (y @ E)),
        x,
        velocity=projected(surface, y @ E),
        viscosity_ratio=0.0,
    )
    assert np.all(np.isnan(flow.velocity[~flow.inside]))
    assert np.abs(flow.velocity[flow.inside] - x[flow.inside] @ E).max() < 1e-2


def test_background_and_the_wall():
    """A sphere at rest in a uniform stream: the far velocity is the stream's."""
    surface = sampled(6)
    stream = np.array([0.0, 0.0, 1.0])
    tau = np.tile(-1.5 * stream, (surface.patches.n_dofs, 1))
    on = surface.outer.points[:5]
    x = np.concatenate([[[0.0, 0.0, 1e4]], on])
    flow = flow_field(surface, tau, x, background=lambda y: np.tile(stream, (len(y), 1)))
    assert flow.velocity[0] == pytest.approx(stream, abs=2e-4)
    assert not flow.wall[0]
    assert flow.wall[1:].all()
    assert np.all(np.isnan(flow.pressure[1:]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"viscosity_ratio": 0.5}, "give the velocity"),
        ({"viscosity_ratio": -1.0}, "not negative"),
        ({"points": np.full((2, 3), np.nan)}, "finite"),
        ({"traction": np.zeros((3, 3))}, "traction: expected"),
    ],
)
def test_wrong_arguments(change, message):
    surface = sampled(6)
    arguments = {"traction": np.zeros((surface.patches.n_dofs, 3)), "points": np.ones((2, 3))}
    with pytest.raises(ValueError, match=message):
        flow_field(surface, **(arguments | change))


def test_streamlines_of_a_vortex_are_circles():
    def vortex(x):
        return np.stack([-x[:, 1], x[:, 0], np.zeros(len(x))], axis=1)

    (line,) = streamlines(vortex, np.array([[1.0, 0.0, 0.5]]), np.pi)
    assert np.linalg.norm(line[:, :2], axis=1) == pytest.approx(1.0, abs=2e-3)
    assert line[0] == pytest.approx([-1.0, 0.0, 0.5], abs=1e-2)
    assert line[-1] == pytest.approx([-1.0, 0.0, 0.5], abs=1e-2)
    with pytest.raises(ValueError, match="length > 0"):
        streamlines(vortex, np.zeros((1, 3)), 0.0)
