"""What a scene's boundary integrals are given before any work starts."""

import pytest

from cases import loader
from cases.kinds.inflation.initial_bag import initial_bag
from cases.kinds.inflation.plan import compression, fluid_budget, quadrature


def prepared(*keys):
    scene = loader.read("pillow", ["geometry.gap=0.02", *keys])
    body = initial_bag(scene)
    asked = fluid_budget(scene, body)
    return quadrature(scene, asked), compression(scene, body, asked)


def test_cross_approximation_gets_one_set_of_points():
    """In a thin gap the budget asks for more far points than outer ones."""
    orders, none = prepared("fluid.compression=dense")
    assert none is None
    assert (orders.outer, orders.source) == (3, 4)
    orders, chosen = prepared("fluid.compression=aca")
    assert (orders.outer, orders.source) == (4, 4)
    assert chosen.method == "aca"


@pytest.mark.parametrize("method", ["aca", "h2"])
def test_operators_are_refused_beyond_the_memory(monkeypatch, method):
    monkeypatch.setattr("cases.kinds.inflation.forecast.memory_bytes", lambda: 1_000_000)
    _, chosen = prepared(f"fluid.compression={method}")
    assert chosen.memory == 800_000
    monkeypatch.setattr("cases.kinds.inflation.forecast.memory_bytes", lambda: 0)
    assert prepared(f"fluid.compression={method}")[1].memory is None
