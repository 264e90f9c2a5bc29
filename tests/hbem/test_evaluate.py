"""The flow off the surface against exact flows in and around a sphere, up to the wall."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from cases.geometry.bodies import sphere
from hbem.double_layer import double_layer
from hbem.evaluate import flow_field
from hbem.krylov import DenseSaddle
from hbem.quadrature import QuadratureOrders
from hbem.single_layer import single_layer
from hbem.stokes import jump_data

STRAIN = np.array([[1.0, 0.5, 0.0], [0.5, -2.0, 0.3], [0.0, 0.3, 1.0]])
ORDERS = QuadratureOrders()


@pytest.fixture(scope="module")
def flow():
    body = sphere(8, 8)
    layer = single_layer(body, body.coefficients)
    return layer, double_layer(layer.surface, ORDERS)


def directions():
    d = np.random.default_rng(5).standard_normal((12, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def solve(flow, velocity, ratio):
    layer, double = flow
    surface = layer.surface
    data = surface.project(velocity(surface.outer.points))
    u = splu(surface.mass.tocsc()).solve(data)
    rhs = jump_data(data.ravel(), ratio, double, u.ravel())
    found = DenseSaddle(layer, surface.constraint, surface.mass).solve(rhs)
    return surface, found.solution.reshape(-1, 3), u


@pytest.mark.parametrize("distance", [0.5, 0.1, 1e-2, 1e-3])
@pytest.mark.parametrize("ratio", [1.0, 0.3])
def test_straining_inside(flow, distance, ratio):
    """Inside the flow is linear. Measured at the wall 1.4e-3 for equal viscosities; 2.9e-3 for
    0.3, which also sees the projection of the velocity into the density space (8 x 8)."""
    surface, tau, u = solve(flow, lambda x: x @ STRAIN, ratio)
    x = (1.0 - distance) * directions()
    found = flow_field(surface, x, tau, ORDERS, velocity=u, viscosity_ratio=ratio)
    assert found.inside.all()
    assert np.abs(found.velocity - x @ STRAIN).max() < (2e-3 if ratio == 1.0 else 3.5e-3)


@pytest.mark.parametrize("distance", [1.0, 0.1, 1e-3])
@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_translation_outside(flow, distance, ratio):
    """Stokes' flow around a moving sphere, whose traction is in the space; measured 2e-6."""
    e = np.array([0.0, 0.0, 1.0])
    surface, tau, u = solve(flow, lambda x: 0.0 * x + e, ratio)
    x = (1.0 + distance) * directions()
    found = flow_field(surface, x, tau, ORDERS, velocity=u, viscosity_ratio=ratio)
    r = np.linalg.norm(x, axis=1, keepdims=True)
    along = x[:, 2:] * x / r**2
    exact = 0.75 * (e + along) / r + 0.25 * (e - 3.0 * along) / r**3
    assert not found.inside.any()
    assert np.abs(found.velocity - exact).max() < 1e-4


@pytest.mark.parametrize("distance", [0.3, 1e-2])
def test_stress_of_translation(flow, distance):
    """Pressure ``3 z / 2 r^3`` outside; on the wall the stress carries the traction."""
    e = np.array([0.0, 0.0, 1.0])
    surface, tau, _ = solve(flow, lambda x: 0.0 * x + e, 1.0)
    n = directions()
    x = (1.0 + distance) * n
    found = flow_field(surface, x, tau, ORDERS, stress=True)
    r = 1.0 + distance
    assert np.abs(found.pressure - 1.5 * x[:, 2] / r**3).max() < 1e-3
    assert np.abs(np.einsum("nii->n", found.stress) + 3.0 * found.pressure).max() < 1e-10
    # at r = 1 the traction from outside is -3/2 e everywhere
    if distance < 0.1:
        wall = np.einsum("nij,nj->ni", found.stress, n)
        assert np.abs(wall + 1.5 * e).max() < 6.0 * distance


def test_wrong_arguments(flow):
    surface, tau, _ = solve(flow, lambda x: x @ STRAIN, 1.0)
    with pytest.raises(ValueError, match="points"):
        flow_field(surface, np.zeros(3), tau, ORDERS)
    with pytest.raises(ValueError, match="velocity"):
        flow_field(surface, np.zeros((1, 3)), tau, ORDERS, viscosity_ratio=2.0)
    with pytest.raises(ValueError, match="stress"):
        flow_field(surface, np.zeros((1, 3)), tau, ORDERS, viscosity_ratio=2.0, stress=True)
