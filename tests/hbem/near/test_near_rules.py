"""Near-singular and singular rules against an adaptive reference, and the closest point."""

import numpy as np
import pytest

from cases.geometry.bodies import fitted, torus
from hbem.near._patch_lane_kernels import exponentials
from hbem.near.closest_point import near_pairs, outer_pairs
from hbem.near.near_rules import near_moments
from hbem.surfaces.bernstein import tensor_bernstein, tensor_bernstein_gradient
from hbem.surfaces.quadrature import QuadratureOrders, gauss_square
from hbem.surfaces.surface_points import sample

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
ELEMENT = 9


def reference(control, x, degree, n=8):
    """Moments by recursive quartering until every piece is farther than its size."""
    s0, t0, w0 = gauss_square(n)
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    total, todo = np.zeros(((degree + 1) ** 2, 6)), [(0.0, 0.0, 1.0)]
    while todo:
        a, c, h = todo.pop()
        s, t = a + h * s0, c + h * t0
        y = tensor_bernstein(g, s, t) @ flat
        ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s, t))
        size = h * max(np.linalg.norm(ys, axis=1).max(), np.linalg.norm(yt, axis=1).max())
        r = x - y
        distance = np.linalg.norm(r, axis=1)
        if distance.min() < size and h > 1e-6:
            half = 0.5 * h
            todo += [(a + i * half, c + j * half, half) for i in (0, 1) for j in (0, 1)]
            continue
        area = np.linalg.norm(np.cross(ys, yt), axis=1) * w0 * h * h / (8 * np.pi)
        kernel = [area * ((i == k) / distance + r[:, i] * r[:, k] / distance**3) for i, k in PAIRS]
        total += tensor_bernstein(degree, s, t).T @ np.stack(kernel, axis=1)
    return total


@pytest.fixture(scope="module", params=["exact", "fitted"])
def surface(request):
    body = torus(8, 8)
    body = body if request.param == "exact" else fitted(body)
    return sample(body, body.coefficients, QuadratureOrders())


@pytest.mark.parametrize("where", [(0.4, 0.55), (0.02, 0.5), (0.01, 0.03), (0.5, 1.0)])
@pytest.mark.parametrize("gap", [0.3, 0.03, 1e-3])
def test_sinh_rule(surface, where, gap):
    """Measured at most 1.7e-6 for any distance (fine orders 3e-9)."""
    control = surface.control[ELEMENT]
    g, flat = control.shape[0] - 1, control.reshape(-1, 3)
    s, t = (np.array([v]) for v in where)
    ys, yt = (table @ flat for table in tensor_bernstein_gradient(g, s, t))
    normal = np.cross(ys, yt)[0]
    area = np.linalg.norm(normal)
    x = (tensor_bernstein(g, s, t) @ flat)[0] + gap * np.sqrt(area) * normal / area
    pairs = near_pairs(surface, x[None], np.array([-1]), 1.0)
    at = list(pairs.elements).index(ELEMENT)
    np.testing.assert_allclose(pairs.closest.rows[at, :2], where, atol=1e-4)
    exact = reference(control, x, 2)
    for orders, bound in ((QuadratureOrders(), 5e-6), (QuadratureOrders.fine(), 1e-8)):
        moments = near_moments(surface, pairs, orders)[at]
        assert np.abs(moments - exact).max() < bound * np.abs(exact).max()


def test_polar_rule_and_neighbours(surface):
    """The point's own element and those that touch it; measured 5e-5, fine 7e-8."""
    point = slice(9 * ELEMENT, 9 * ELEMENT + 1)
    pairs = outer_pairs(surface, QuadratureOrders(), point)
    assert ELEMENT in pairs.elements
    assert pairs.n_pairs >= 9
    fine = near_moments(surface, pairs, QuadratureOrders.fine())
    usual = near_moments(surface, pairs, QuadratureOrders())
    for k, e in enumerate(pairs.elements):
        exact = reference(surface.control[e], pairs.points[0], 2)
        size = np.abs(exact).max()
        assert np.abs(usual[k] - exact).max() < 1e-4 * size
        assert np.abs(fine[k] - exact).max() < 1e-7 * size


def test_plain_rule_is_subtracted(surface):
    """Accurate moments minus the corrected ones are the plain rule, coincident points skipped."""
    orders = QuadratureOrders()
    pairs = outer_pairs(surface, orders, slice(0, 18))
    accurate = near_moments(surface, pairs, orders)
    corrected = near_moments(surface, pairs, orders, minus_plain=True)
    n = surface.centres.shape[0]
    source, basis = surface.source, tensor_bernstein(2, surface.source.s, surface.source.t)
    point_of = np.repeat(np.arange(18), np.diff(pairs.indptr))
    r = pairs.points[point_of, None] - source.points.reshape(n, -1, 3)[pairs.elements]
    distance = np.linalg.norm(r, axis=-1)
    with np.errstate(divide="ignore"):
        inverse = np.where(distance > 1e-10, 1.0 / distance, 0.0)
    weights = source.weights.reshape(n, -1)[pairs.elements] / (8 * np.pi)
    for c, (i, k) in enumerate(PAIRS):
        kernel = weights * ((i == k) * inverse + r[..., i] * r[..., k] * inverse**3)
        difference = accurate[:, :, c] - corrected[:, :, c] - kernel @ basis
        assert np.abs(difference).max() < 1e-13


@pytest.mark.parametrize(("largest", "bound"), [(15.0, 1e-13), (22.0, 4e-13)])
def test_exponentials_of_lanes(largest, bound):
    """Measured 4.7e-14 and 2.1e-13; polar rules alone go beyond 15."""
    x = np.linspace(-largest, largest, 1001)
    found = np.empty(x.size)
    exponentials(x, found)
    np.testing.assert_allclose(found, np.exp(x), rtol=bound)
