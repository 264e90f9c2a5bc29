"""What a scene's boundary integrals are given before any work starts."""

import pytest

from cases import loader
from cases.kinds import simulation
from cases.kinds.inflation import plan
from coupling import OperatorReuse


def planned(*keys):
    return plan.InflationPlan(loader.read("pillow", ["geometry.gap=0.02", *keys]))


def test_cross_approximation_gets_one_set_of_points():
    """In a thin gap the budget asks for more far points than outer ones."""
    dense = planned("fluid.compression=dense")
    assert dense.compression is None
    assert (dense.orders.outer, dense.orders.source) == (3, 4)
    aca = planned("fluid.compression=aca")
    assert (aca.orders.outer, aca.orders.source) == (4, 4)
    assert aca.compression.method == "aca"


@pytest.mark.parametrize("method", ["aca", "h2"])
def test_operators_are_refused_beyond_the_memory(monkeypatch, method):
    monkeypatch.setattr(plan, "memory_bytes", lambda: 1_000_000)
    assert planned(f"fluid.compression={method}").compression.memory == 800_000
    monkeypatch.setattr(plan, "memory_bytes", lambda: 0)
    assert planned(f"fluid.compression={method}").compression.memory is None


def test_a_scene_is_worked_out_once(monkeypatch):
    """One bag serves forecast or run; it was built five times."""
    from cases.kinds import KINDS

    built = []
    real = plan.initial_bag
    monkeypatch.setattr(plan, "initial_bag", lambda scene: built.append(1) or real(scene))
    scene = loader.read("pancake", ["mesh.degree=2", "mesh.around=8"])
    KINDS["inflation"].forecast(scene)
    assert len(built) == 1
    KINDS["inflation"].simulated(scene).simulation()
    assert len(built) == 2


def test_a_run_can_tell_how_its_fluid_is_compressed():
    """run.json reads them from the fluid of the run, whose operators are reused by default."""
    scene = loader.read("pillow", ["mesh.around=16", "mesh.across=8", "fluid.compression=h2"])
    fluid = simulation(scene).fluid
    assert isinstance(fluid, OperatorReuse)
    assert fluid.statistics is fluid.fluid.statistics
