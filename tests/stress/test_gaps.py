"""Boundary integrals on ugly surfaces: the answer stays right, or the surface is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cases.benchmarks.integrals.gaps import RIM, disc
from cases.geometry import bodies
from cases.geometry.bodies import from_control_points, sphere, torus
from cases.geometry.pillows.pillow import round_bag
from hbem.flows.stokes_flow import StokesFlow
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import IterativeSaddle
from hbem.solvers.schwarz import two_level_schwarz
from hbem.surfaces.patches import BezierPatches, union
from hbem.surfaces.quadrature import QuadratureOrders

pytestmark = pytest.mark.slow
PULL = np.array([1.0, 0.4, -0.2])
DRAG = np.array([0.0, 0.0, 6.0 * np.pi])


def change(body: BezierPatches) -> float:
    """Relative change of the force when the rules are refined."""
    forces = [
        StokesFlow(body, orders=orders, measure="none").traction(PULL).force()[0]
        for orders in (QuadratureOrders(), QuadratureOrders.fine())
    ]
    return float(np.linalg.norm(forces[0] - forces[1]) / np.linalg.norm(forces[1]))


def shuffled(body: BezierPatches, seed: int) -> BezierPatches:
    """Elements in random order, each with its local axes turned by a multiple of 90 degrees."""
    rng = np.random.default_rng(seed)
    g, q = body.geometry_degree + 1, body.density_degree + 1
    geometry = np.arange(g * g).reshape(g, g)
    density = np.arange(q * q).reshape(q, q)
    points, rows, tables, counts = [], [], [], [0]
    for e in rng.permutation(body.n_elements):
        turns = int(rng.integers(4))
        own = np.arange(body.indptr[e], body.indptr[e + 1])
        points.append(e * g * g + np.rot90(geometry, turns).ravel())
        rows.append(own)
        tables.append(body.extraction[own][:, np.rot90(density, turns).ravel()])
        counts.append(own.size)
    return replace(
        body,
        indptr=np.cumsum(counts),
        dofs=body.dofs[np.concatenate(rows)],
        extraction=np.concatenate(tables),
        bezier=body.bezier.tocsr()[np.concatenate(points)],
    )


def test_elements_of_aspect_fifty():
    """A thin ring: elements 0.4 x 21."""
    assert change(torus(16, 6, major=20.0)) < 1e-3


@pytest.mark.parametrize("seed", [0, 1])
def test_order_and_axes_of_elements_do_not_matter(seed):
    body = sphere(5, 6)
    forces = [
        StokesFlow(b, orders=QuadratureOrders.fine(), measure="none").traction(PULL).force()
        for b in (body, shuffled(body, seed))
    ]
    np.testing.assert_allclose(forces[1], forces[0], rtol=0, atol=1e-5)


def test_duplicated_control_points():
    """Two equal rings of control points: the parametrisation stands still on a line."""
    angle = 2.0 * np.pi * np.arange(8) / 8
    phi = -2.0 * np.pi * np.arange(10) / 10
    rho = 3.0 + np.cos(angle)[:, None]
    z = np.broadcast_to(np.sin(angle)[:, None], (8, 10))
    ring = np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=-1)
    doubled = np.concatenate([ring[:3], ring[2:]])
    assert change(from_control_points(doubled, ends="periodic")) < 1e-3


@pytest.mark.parametrize("n", [(3, 3), (3, 4)])
def test_elements_that_turn_far(n, monkeypatch):
    """Elements of a sphere that turn by 60 by 120 and 90 degrees."""
    monkeypatch.setattr(bodies, "FIT", 1e-7)  # degree 8 over 120 degrees: the sphere to 2e-8
    found = StokesFlow(sphere(*n), measure="none").traction(np.array([0.0, 0.0, 1.0])).force()
    np.testing.assert_allclose(found[0], DRAG, atol=1e-3)


def test_facing_sheets_shifted_by_half_an_element():
    """Discs a thousandth of an element apart, one turned by half an element."""
    n_t = 8
    gap = 1e-3 * 2.0 * np.pi / n_t
    upper, lower = disc(14, n_t, 0.5 * gap + RIM), disc(14, n_t, -0.5 * gap - RIM)
    c, s = np.cos(np.pi / n_t), np.sin(np.pi / n_t)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    body = union(upper, lower)
    coefficients = np.concatenate([upper.coefficients, lower.coefficients @ turn.T])
    matrices = [
        single_layer(body, coefficients, orders).dense()
        for orders in (QuadratureOrders(), QuadratureOrders.fine())
    ]
    error = np.linalg.norm(matrices[0] - matrices[1]) / np.linalg.norm(matrices[1])
    assert error < 1e-5


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_gap_solver_does_not_see_units(scale):
    bag = round_bag(20, gap=0.05)
    found = []
    for factor in (1.0, scale):
        layer = single_layer(bag.patches(), factor * bag.coefficients)
        surface = layer.surface
        data = surface.project(np.cross(PULL, surface.outer.points / factor)).ravel()
        system = IterativeSaddle(
            layer, surface.constraint, surface.mass, 1e-9, preconditioner=two_level_schwarz
        )
        found.append(system.solve(data))
    assert abs(found[0].iterations - found[1].iterations) <= 1
    np.testing.assert_allclose(
        scale * found[1].solution,
        found[0].solution,
        rtol=0,
        atol=1e-6 * np.abs(found[0].solution).max(),
    )
