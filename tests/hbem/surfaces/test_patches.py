"""Bernstein helpers, Bezier tables and exact bodies."""

import numpy as np
import pytest

from cases.geometry.bodies import fitted, sphere, spheroid, torus
from hbem.surfaces.bernstein import bernstein, bernstein_derivative, centred_powers
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders, gauss_tables
from hbem.surfaces.surface_points import sample


@pytest.mark.parametrize("degree", [0, 1, 3, 8])
def test_bernstein(degree):
    x = np.linspace(0.0, 1.0, 7)
    values = bernstein(degree, x)
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-14)
    if degree:
        np.testing.assert_allclose(values @ np.arange(degree + 1) / degree, x, atol=1e-15)
    step = 1e-6
    slope = (bernstein(degree, x + step) - bernstein(degree, x - step)) / (2 * step)
    np.testing.assert_allclose(bernstein_derivative(degree, x), slope, atol=1e-7)


def test_gauss_tables():
    nodes, weights = gauss_tables()
    assert np.allclose(weights[1:].sum(axis=1), 1.0)
    assert nodes[3] @ (weights[3] * nodes[3] ** 4) == pytest.approx(1 / 6)


@pytest.mark.parametrize("degree", [2, 3, 8])
def test_centred_powers(degree):
    x = np.linspace(0.0, 1.0, 9)
    monomials = (2.0 * x[:, None] - 1.0) ** np.arange(degree + 1)
    np.testing.assert_allclose(monomials @ centred_powers(degree), bernstein(degree, x), atol=1e-13)


@pytest.mark.parametrize(
    ("body", "area", "volume"),
    [
        (sphere(8, 8), 4 * np.pi, 4 / 3 * np.pi),
        (sphere(8, 8, radius=2.0, degree=3, pole="c1"), 16 * np.pi, 32 / 3 * np.pi),
        (torus(6, 10), 12 * np.pi**2, 6 * np.pi**2),
        (spheroid(8, 8, a=2.0, c=0.5, grading=0.3), None, 8 / 3 * np.pi),
    ],
)
def test_exact_bodies(body, area, volume):
    outer = sample(body, body.coefficients, QuadratureOrders(outer=8)).outer
    if area:
        assert outer.weights.sum() == pytest.approx(area, rel=1e-8)
    enclosed = outer.weights @ np.sum(outer.points * outer.normals, axis=1) / 3
    assert enclosed == pytest.approx(volume, rel=1e-8)


def test_fitted_body_is_close():
    body = fitted(sphere(8, 8, degree=3, pole="c1"))
    points = sample(body, body.coefficients, QuadratureOrders()).outer.points
    assert np.abs(np.linalg.norm(points, axis=1) - 1.0).max() < 1e-3
    assert body.coefficients.shape == (body.n_dofs, 3)


def test_coarse_mesh_is_refused():
    with pytest.raises(AssertionError, match="refine"):
        sphere(2, 2)


def test_contradicting_tables():
    body = torus(4, 4)
    with pytest.raises(ValueError, match="table rows"):
        BezierPatches(16, 8, 2, body.indptr, body.dofs[:-1], body.extraction, body.bezier)
    with pytest.raises(ValueError, match="outside"):
        BezierPatches(15, 8, 2, body.indptr, body.dofs, body.extraction, body.bezier)
