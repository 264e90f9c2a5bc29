"""The compressed single layer of a bag: against dense, its solve, its statistics."""

import numpy as np
import pytest

from cases.geometry.bodies import sphere, torus
from cases.geometry.pillows.pillow import round_bag
from hbem.compression import h2matrix
from hbem.compression.near_part.stored_near import stored_near
from hbem.layers.choice import Compression, choose
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import IterativeSaddle
from hbem.surfaces.quadrature import QuadratureOrders


def layers(body, method, tolerance, orders=None):
    surface = getattr(body, "surface", body)
    args = (surface, body.coefficients, orders)
    compressed = single_layer(*args, compression=Compression(method, tolerance))
    return compressed, single_layer(*args, storage="dense")


@pytest.mark.parametrize("method", ["aca", "h2"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
@pytest.mark.parametrize(
    "body",
    [pytest.param(torus(16, 16), marks=pytest.mark.slow), round_bag(14, gap=0.05)],
    ids=["torus", "bag"],
)
def test_against_dense(body, method, tolerance):
    compressed, dense = layers(body, method, tolerance)
    x = np.random.default_rng(0).standard_normal((dense.shape[0], 2))
    x[:, 1] = np.tile([1.0, 2.0, 3.0], dense.shape[0] // 3)
    exact = dense @ x
    error = np.linalg.norm(compressed @ x - exact, axis=0) / np.linalg.norm(exact, axis=0)
    assert error.max() <= tolerance
    assert compressed.plain.statistics.achieved <= tolerance


def test_different_source_points():
    """H2 takes two sets of points; ACA says that it does not."""
    orders = QuadratureOrders(outer=2, far=3)
    compressed, dense = layers(torus(12, 12), "h2", 1e-4, orders)
    x = np.random.default_rng(0).standard_normal(dense.shape[0])
    assert np.linalg.norm(compressed @ x - dense @ x) <= 1e-4 * np.linalg.norm(dense @ x)
    turned = dense.T @ x
    assert np.linalg.norm(compressed.T @ x - turned) <= 1e-4 * np.linalg.norm(turned)
    with pytest.raises(ValueError, match="equal outer and source points"):
        layers(torus(12, 12), "aca", 1e-4, orders)


@pytest.mark.parametrize("orders", [QuadratureOrders(), QuadratureOrders(outer=2, far=3)])
def test_near_part_stored_or_summed(orders, monkeypatch):
    """The same boxes between functions and, where there is no room, between points."""
    body = torus(12, 12)
    args = (body, body.coefficients, orders)
    stored = single_layer(*args, compression=Compression("h2", 1e-5))
    monkeypatch.setattr(h2matrix, "stored_near", lambda *most: stored_near(*most[:-1], 1e5))
    summed = single_layer(*args, compression=Compression("h2", 1e-5))
    assert stored.plain.near is not None
    assert summed.plain.near is None
    x = np.random.default_rng(0).standard_normal((stored.shape[0], 2))
    for a, b in ((stored, summed), (stored.T, summed.T)):
        np.testing.assert_allclose(a @ x, b @ x, atol=1e-13 * np.abs(a @ x).max())


@pytest.mark.parametrize("method", ["aca", "h2"])
def test_drag_of_a_sphere(method):
    """Solved with the compressed operator: a translating sphere has traction -3/2 per unit."""
    body = sphere(8, 16)
    compressed, _ = layers(body, method, 1e-5)
    surface = compressed.surface
    system = IterativeSaddle(compressed, surface.constraint, surface.mass, tolerance=1e-7)
    rhs = (surface.mass @ np.tile([0.0, 0.0, 1.0], (body.n_dofs, 1))).ravel()
    solved = system.solve(rhs)
    assert solved.result.ok
    force = (surface.mass @ solved.solution.reshape(-1, 3)).sum(axis=0)
    assert force[2] == pytest.approx(6.0 * np.pi, rel=1e-5)


def test_statistics_name_everything():
    compressed, _ = layers(torus(12, 12), "h2", 1e-3)
    record = compressed.statistics()
    for key in ("achieved", "rank_max", "bytes_far", "ratio", "build_seconds"):
        assert np.isfinite(record[key]), key
    assert "near correction" in repr(compressed)
    with pytest.raises(TypeError, match="no entries to index"):
        compressed[0, 0]


def test_choice():
    tolerances = {"aca": 5e-5, "h2": 1e-3}
    small = {"n_dofs": 500, "n_outer": 4500, "n_source": 4500}
    large = {"n_dofs": 30000, "n_outer": 270000, "n_source": 270000}
    assert choose("auto", tolerances, **small) is None
    assert choose("dense", tolerances, **large) is None
    assert choose("auto", tolerances, **large).method == "h2"
    assert choose("auto", tolerances, **large, products=10**5).method == "aca"
    assert choose("aca", tolerances, **small).tolerance == 5e-5
    with pytest.raises(ValueError, match="none of"):
        Compression("fmm", 1e-3)
