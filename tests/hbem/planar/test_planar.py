"""Planar boundary integrals: closed forms, identities, exact flows, contact force."""

import numpy as np
import pytest

from cases.benchmarks.planar import layers as layers
from cases.kinds.planar import exact
from hbem.planar.contact import ContactForce
from hbem.planar.polygon import Boundary, OuterRule, crossing, edges, meeting, smallest_gap
from hbem.planar.potential import PlanarPotential
from hbem.planar.stokes import PlanarStokes, StokesSystem, stokes_layers


@pytest.fixture(scope="module")
def boundary():
    """A half circle over an inlet, 12 elements."""
    s = np.linspace(0.0, np.pi, 13)
    coefficients = np.stack(
        [np.column_stack([np.cos(s), np.sin(s)]), np.column_stack([-np.sin(s), np.cos(s)])], axis=1
    ).reshape(-1, 2)
    x = np.linspace(-1.0, 1.0, 5)[1:-1]
    return Boundary(s, np.column_stack([x, 0.0 * x]), 1.0 - x**2), coefficients


def test_self_integrals_equal_quadrature():
    stokes, potential, double = layers.self_errors()
    assert max(stokes, potential) < 1e-9
    assert double == 0.0


def test_double_layer_of_constants():
    stokes, potential = layers.constants_error()
    assert stokes < 1e-7  # measured 2e-9
    assert potential < 1e-7


def test_single_layer_is_symmetric():
    V, _ = stokes_layers(exact.quadrilateral(6), double=False)
    assert np.abs(V - V.T).max() < 1e-6 * np.abs(V).max()


def test_rates():
    traction = [layers.stokes_error(n) for n in (8, 16)]
    potential = [layers.potential_error(n) for n in (8, 16)]
    assert np.log2(traction[0] / traction[1]) > 1.4  # measured 1.45, tends to 1.5
    assert np.log2(potential[0] / potential[1]) > 1.9  # measured 1.94


def test_critical_size():
    assert abs(layers.critical_radius(32) / np.sqrt(np.e) - 1.0) < 1e-2
    assert layers.negative_eigenvalues(2.0, 100.0, n=32) == 0


def test_scaling_leaves_interior_tractions_alone():
    points = exact.quadrilateral(8)
    u, _ = exact.quadratic_flow(exact.ends(points))
    # the interpolated data have a small net flux, which the multiplier takes
    lengths, normals = edges(points)
    both = np.repeat(normals, 2, axis=0)
    u -= both * np.sum(u * exact.tested(lengths, both)) / lengths.sum()
    tau = [StokesSystem(points, log_radius=s).solve(u.reshape(-1, 1))[0] for s in (3.0, 300.0)]
    # only the discrete total force, zero up to the discretisation, sees s
    assert (
        np.abs(tau[0] - tau[1]).max() < 1e-4 * np.abs(tau[0]).max()
    )  # measured 1.3e-4 on 4 a side, 6e-6 on 16


def test_squeeze_film():
    for H, n, bound in ((0.01, 10, 5e-3), (0.001, 10, 3e-2)):
        load, true = layers.squeeze_load(H, n)
        assert abs(load / true - 1.0) < bound  # measured 3e-4, 1e-4
    plain, true = layers.squeeze_load(0.01, 10, OuterRule(4, 0))
    assert abs(plain / true - 1.0) > 0.5


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0])
def test_response_is_the_load_of_the_traction(boundary, ratio):
    shape, coefficients = boundary
    operator = PlanarStokes(shape, 0.01, ratio).assemble(coefficients)
    v = np.random.default_rng(1).standard_normal(coefficients.shape)
    load = operator.load(operator.traction(v))
    response = operator.response()
    assert np.allclose((response @ v.ravel()).reshape(-1, 2), load, rtol=1e-10)
    assert np.allclose((response.dense() @ v.ravel()).reshape(-1, 2), load, rtol=1e-10, atol=1e-14)


def test_influx_balances_the_membrane(boundary):
    shape, coefficients = boundary
    at = shape.at(coefficients)
    v = np.random.default_rng(2).standard_normal(coefficients.shape)
    nodal = at.nodal_velocity(v)
    mean = 0.5 * (nodal + np.roll(nodal, -1, axis=0))
    # random ends move the inlet's first segments as well
    v[0] = v[-2] = 0.0
    nodal = at.nodal_velocity(v)
    mean = 0.5 * (nodal + np.roll(nodal, -1, axis=0))
    assert abs(np.sum(at.lengths[:, None] * at.normals * mean)) < 1e-13


def test_stokes_dissipates(boundary):
    """Power of the load is negative for both viscosity ratios."""
    shape, coefficients = boundary
    v = np.random.default_rng(3).standard_normal(coefficients.shape)
    v[0] = v[-2] = 0.0
    v[1::2] = 0.0
    for ratio in (0.0, 1.0):
        operator = PlanarStokes(shape, 1.0, ratio).assemble(coefficients)
        nodal = operator.at.nodal_velocity(v)
        tau = operator.traction(v).coefficients
        both = shape.trace @ nodal
        assert np.sum(both * exact.tested(operator.at.lengths, tau)) > 0.0


def test_potential_refuses_a_linear_response(boundary):
    shape, coefficients = boundary
    operator = PlanarPotential(shape, 0.1).assemble(coefficients)
    with pytest.raises(TypeError, match="partitioned"):
        operator.response()


def test_contact_force_is_bounded_and_reciprocal():
    force = ContactForce(1.0, 2.0)
    points = exact.slot(0.1, 30, 3)
    lengths, _ = edges(points)
    total = np.einsum("e,epi->i", lengths, force.tractions(points))
    assert np.abs(total).max() < 1e-10  # Newton's third law
    assert abs(layers.contact_pressure(0.1, 120) / force.bound - 1.0) < 0.05


def test_crossing_and_gap():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert crossing(square) is None
    assert crossing(square[[0, 2, 1, 3]]) is not None
    assert abs(smallest_gap(exact.slot(0.05, 8, 2)) - 0.1) < 1e-14


def test_bad_input_is_named(boundary):
    shape, _ = boundary
    with pytest.raises(ValueError, match="viscosity_ratio"):
        PlanarStokes(shape, 1.0, -1.0)
    with pytest.raises(ValueError, match="mass_ratio"):
        PlanarPotential(shape, 0.0)
    with pytest.raises(ValueError, match="magnitude"):
        ContactForce(0.0, 1.0)
    with pytest.raises(ValueError, match="inner node"):
        Boundary(np.arange(3.0), np.empty((0, 2)), np.empty(0))


def test_walls_that_pass_each_other_are_seen():
    """An arm swings past a post: both ends of the motion are free, its middle is not."""
    start = np.array(
        [
            *([-1.5, -1], [1.5, -1], [1.5, 0], [0.05, 0], [0, 0.8], [-0.05, 0], [-0.9, 0]),
            *([-0.9, 1.9], [-0.5, 0.5], [-1, 2.5], [-1.5, 0]),
        ]
    )
    end = start.copy()
    end[8] = [0.5, 0.5]
    assert crossing(start) is None
    assert crossing(end) is None
    assert meeting(start, end) is not None
    assert meeting(end, start) is not None
    assert meeting(start, start) is None
    beside = start.copy()
    beside[8] = [-0.1, 0.4]
    assert meeting(start, beside) is None


def test_meetings_equal_those_of_small_steps():
    """Random motions of a star: the exact test against crossings on 2000 ways between."""
    rng = np.random.default_rng(3)
    angle = 2.0 * np.pi * np.arange(14) / 14
    found = 0
    for _ in range(60):
        radii = rng.uniform(0.3, 1.0, (2, 14))
        start = radii[0][:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        end = radii[1][:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        end += rng.uniform(-0.35, 0.35, (14, 2))
        sampled = any(
            crossing((1.0 - t) * start + t * end) is not None for t in np.linspace(0, 1, 2001)
        )
        assert (meeting(start, end) is not None) == sampled
        found += sampled
    assert 10 < found < 50
