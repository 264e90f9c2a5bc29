"""The double layer: near rules, Gauss identity, and flows of any viscosity ratio about a sphere."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from cases.geometry.bodies import fitted, sphere, torus
from hbem.flows.formulation import exterior_data, jump_data
from hbem.layers.double_layer import double_layer
from hbem.layers.single_layer import single_layer
from hbem.near.closest_point import near_pairs
from hbem.near.near_rules import Layer, near_moments
from hbem.solvers.saddle import DenseSaddle
from hbem.surfaces.bernstein import tensor_bernstein, tensor_bernstein_gradient
from hbem.surfaces.quadrature import QuadratureOrders, gauss_square
from hbem.surfaces.surface_points import sample

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
STRAIN = np.array([[1.0, 0.5, 0.0], [0.5, -2.0, 0.3], [0.0, 0.3, 1.0]])


def reference(control, x, degree, n=8):
    """Double-layer moments by recursive quartering."""
    s0, t0, w0 = gauss_square(n)
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    total, todo = np.zeros(((degree + 1) ** 2, 6)), [(0.0, 0.0, 1.0)]
    while todo:
        a, c, h = todo.pop()
        s, t = a + h * s0, c + h * t0
        r = x - tensor_bernstein(g, s, t) @ flat
        ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s, t))
        size = h * max(np.linalg.norm(ys, axis=1).max(), np.linalg.norm(yt, axis=1).max())
        distance = np.linalg.norm(r, axis=1)
        if distance.min() < size and h > 1e-6:
            half = 0.5 * h
            todo += [(a + i * half, c + j * half, half) for i in (0, 1) for j in (0, 1)]
            continue
        f = 0.75 / np.pi * w0 * h * h * np.sum(r * np.cross(ys, yt), axis=1) / distance**5
        kernel = np.stack([f * r[:, i] * r[:, k] for i, k in PAIRS], axis=1)
        total += tensor_bernstein(degree, s, t).T @ kernel
    return total


@pytest.mark.parametrize("where", [(0.4, 0.55), (0.02, 0.5), (0.01, 0.03), (0.5, 1.0)])
@pytest.mark.parametrize("gap", [0.3, 0.03, 1e-3])
def test_split_rule(where, gap):
    """Near-singular double-layer moments against an adaptive reference, fine orders."""
    body = fitted(torus(8, 8))
    surface = sample(body, body.coefficients, QuadratureOrders())
    control = surface.control[9]
    s, t = (np.array([v]) for v in where)
    ys, yt = (table @ control.reshape(-1, 3) for table in tensor_bernstein_gradient(2, s, t))
    normal = np.cross(ys, yt)[0]
    area = np.linalg.norm(normal)
    y = (tensor_bernstein(2, s, t) @ control.reshape(-1, 3))[0]
    x = y + gap * np.sqrt(area) * normal / area
    pairs = near_pairs(surface, x[None], np.array([-1]), 1.0)
    at = list(pairs.elements).index(9)
    exact = reference(control, x, 2)
    found = near_moments(surface, pairs, QuadratureOrders.fine(), Layer.DOUBLE)[at]
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.fixture(scope="module")
def system():
    body = sphere(8, 8)
    layer = single_layer(body, body.coefficients)
    return layer, double_layer(layer.surface, QuadratureOrders())


def test_constants_and_gauss_identity(system):
    """K of a constant is minus half of it, pointwise; the defect is the quadrature error."""
    layer, double = system
    one = np.tile([1.0, -2.0, 0.5], layer.surface.patches.n_dofs)
    expected = -0.5 * layer.surface.project(np.tile([1.0, -2.0, 0.5], (576, 1))).ravel()
    np.testing.assert_allclose(double @ one, expected, atol=1e-14)
    assert double.gauss_error < 1e-3


def test_matrix_is_the_action(system):
    _, double = system
    x = np.random.default_rng(0).standard_normal((double.shape[0], 2))
    action = double @ x
    np.testing.assert_allclose(double.dense() @ x, action, atol=1e-12 * np.abs(action).max())


def errors(system, velocity, exact, ratio, exterior=False):
    layer, double = system
    surface = layer.surface
    x, normals, weights = surface.outer.points, surface.outer.normals, surface.outer.weights
    data = surface.project(velocity(x))
    projected = splu(surface.mass.tocsc()).solve(data)
    data, projected = data.ravel(), projected.ravel()
    if exterior:
        rhs = exterior_data(data, double, projected)
    else:
        rhs = jump_data(data, ratio, double, projected)
    found = DenseSaddle(layer, surface.constraint, surface.mass).solve(rhs)
    tau, reference = surface.basis @ found.solution.reshape(-1, 3), exact(x, normals)
    reference = reference - normals * (weights @ np.sum(reference * normals, 1)) / weights.sum()
    size = weights @ np.sum(reference**2, axis=1)
    return np.sqrt(weights @ np.sum((tau - reference) ** 2, axis=1) / size)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 3.0])
def test_sphere_of_any_viscosity_ratio(system, ratio):
    """Straining ``(2 + 3 lambda) E n`` and rotation ``3 lambda Omega x n``; n = 8: 3e-3."""
    strain = errors(system, lambda x: x @ STRAIN, lambda x, n: (2 + 3 * ratio) * n @ STRAIN, ratio)
    assert strain < 3.5e-3
    if ratio > 0.0:
        axis = np.array([0.0, 0.0, 1.0])
        spin = errors(
            system, lambda x: np.cross(axis, x), lambda x, n: 3 * ratio * np.cross(axis, n), ratio
        )
        assert spin < 4e-3


def test_exterior(system):
    """Traction from outside on a straining sphere, ``-3 E n`` in units of the outer viscosity."""
    found = errors(system, lambda x: x @ STRAIN, lambda x, n: -3.0 * n @ STRAIN, 1.0, exterior=True)
    assert found < 3.5e-3


def test_background_flow(system):
    """A fixed sphere in uniform flow feels the drag of a moving one, reversed."""
    layer, double = system
    surface = layer.surface
    flow = surface.project(np.tile([1.0, 0.0, 0.0], (576, 1))).ravel()
    rhs = jump_data(0.0 * flow, 2.0, double, 0.0 * flow, background=flow)
    found = DenseSaddle(layer, surface.constraint, surface.mass).solve(rhs)
    force = surface.mass.sum(axis=0) @ found.solution.reshape(-1, 3)
    np.testing.assert_allclose(np.ravel(force), [-12 * np.pi, 0.0, 0.0], atol=1e-4)


def test_torus_shear():
    """[T 6.3.2] interior shear on a torus: best approximation, 3.75e-3 on 8 x 8."""
    body = torus(8, 8)
    layer = single_layer(body, body.coefficients)
    system = layer, double_layer(layer.surface, QuadratureOrders())
    found = errors(
        system,
        lambda x: np.stack([x[:, 2], 0 * x[:, 0], 0 * x[:, 0]], axis=1),
        lambda x, n: np.stack([n[:, 2], 0 * n[:, 0], n[:, 0]], axis=1),
        0.0,
    )
    assert found < 4e-3


def test_wrong_ratio(system):
    with pytest.raises(ValueError, match="not negative"):
        jump_data(np.zeros(3), -1.0, None)
    with pytest.raises(ValueError, match="double layer"):
        jump_data(np.zeros(3), 0.5, None)
