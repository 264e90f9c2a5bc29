"""Forecast of what will be hard, against runs: who touches, who snaps, whose film holds back.

Measured (uniform pressure or Stokes flow): `accordion-2` opens without touching at a rigidity of
1e-5 and touches from V/V0 = 2.15 on at 1e-7; `accordion-2-long` touches at 1e-5 (2.7) and 3.6e-6
(2.3), not at 4e-5; `roll-2` at 1.24; folded accordions of four folds spring shut.
"""

from dataclasses import replace

import pytest

from cases import loader
from cases.kinds.inflation.carried import opening_pressure
from cases.kinds.inflation.difficulty import difficulty, facing_distance, time_of, touch
from cases.kinds.inflation.plan import InflationPlan


def found(name, *overrides):
    scene = loader.read(name, list(overrides))
    plan = InflationPlan(scene)
    assert plan.bag.folding is not None
    return scene, plan


@pytest.mark.parametrize(
    ("name", "rigidity", "surely", "volume"),
    [
        ("accordion-2", 1e-5, False, None),
        ("accordion-2", 1e-7, True, 2.15),
        ("accordion-2-long", 4e-5, False, None),
        ("accordion-2-long", 1e-5, True, 2.7),
        ("accordion-2-long", 3.6e-6, True, 2.3),
        ("roll-2", 4e-6, True, 1.24),
    ],
)
def test_touch_is_foretold(name, rigidity, surely, volume):
    scene, plan = found(name, f"structure.flexural_rigidity={rigidity}", "mesh.around=28")
    told = touch(scene, plan.bag, opening_pressure(scene, plan.bag))
    assert told.surely is surely
    if volume is not None:
        assert told.volume == pytest.approx(volume, rel=0.25)


def test_times_invert_the_inflow():
    """Volume 1 + (V - 1) (t - t1 / 2) / t2 while the influx is constant."""
    scene, _ = found("accordion-2")
    i = scene.inflow
    volume = 1.0 + (i.final_volume - 1.0) * (60.0 - 0.5 * i.t1) / i.t2
    assert time_of(scene, volume) == pytest.approx(60.0, abs=0.05)
    assert time_of(scene, 2.0 * i.final_volume) == float("inf")


def test_film_and_snap():
    """0.025 over an opening pressure of 0.02: the group of `accordion-2` is near 1.25."""
    items, warnings = difficulty(found("accordion-2")[1])
    group = {item.name: item.value for item in items}["film's group"]
    assert group == pytest.approx(1.25, rel=0.15)
    assert warnings == []
    _, warnings = difficulty(found("accordion-2", "fluid.mass_ratio=5e-4")[1])
    assert [w for w in warnings if "lower fluid.mass_ratio" in w]
    items, warnings = difficulty(found("accordion-4", "structure.reference=folded")[1])
    energy = {item.name: item.value for item in items}["energy of the folds"]
    assert energy == pytest.approx(2.3e-3, rel=0.2)  # that of the fitted bag
    assert [w for w in warnings if "spring open" in w]


def test_contact_is_told_with_the_nearest_sheets():
    """Rounded corners of the fitted accordion face each other at a quarter of the gap."""
    plan = found("accordion-2")[1]
    near = facing_distance(plan.bag)
    assert near == pytest.approx(0.0059, rel=0.05)
    _, warnings = difficulty(found("accordion-2", "contact.reach=0.4")[1])
    assert "lower contact.reach to 0.24" in warnings[0]
    none = difficulty(found("accordion-2", "contact.force=none", "fluid.model=pressure")[1])[0]
    assert {item.name: item.value for item in none}["contact"] == "none"


def test_contact_of_cloth_without_rigidity_carries():
    """No bending energy says nothing of the pressure; a share of the stiffness stands in for it."""
    scene = loader.read("accordion-2-thin", ["structure.flexural_rigidity=0"])
    assert opening_pressure(scene, InflationPlan(scene).bag) == 0.0
    assert InflationPlan(scene).carried.stiffness == pytest.approx(8e-4)
    items, warnings = difficulty(InflationPlan(scene))
    assert "film's group" not in {item.name for item in items}
    assert not any("m Q length" in text for text in warnings)
    shipped = InflationPlan(loader.read("accordion-2-thin")).carried
    assert shipped.stiffness == pytest.approx(3.44e-3, rel=1e-2)


def test_a_bag_that_was_flat_has_contact_lines_without_its_folding():
    """As from a file that brings its unfolded bag: reach and distance at rest are those."""
    scene, plan = found("accordion-2-coarse")
    bare = InflationPlan(scene, replace(plan.bag, folding=None))
    assert bare.carried.reach == plan.carried.reach
    names = [item.name for item in difficulty(bare)[0]]
    assert "contact reach" in names
    assert "opening pressure" not in names
