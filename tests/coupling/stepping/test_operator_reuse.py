"""Operators reused while the geometry moves too little to matter."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from coupling.stepping.operator_reuse import OperatorReuse, reach


@dataclass
class Fluid:
    assembled: list = field(default_factory=list)

    def assemble(self, coefficients):
        self.assembled.append(coefficients)
        return len(self.assembled)

    def reset(self):
        self.assembled.append("reset")


def test_reused_within_reach_of_where_it_was_assembled():
    """Small moves do not add up unnoticed: they count from the assembled geometry."""
    fluid = Fluid()
    reuse = OperatorReuse(fluid, 1e-3)
    x = np.zeros((4, 3))
    assert reuse.assemble(x) == 1
    assert reuse.assemble(x + 4e-4) == 1
    assert reuse.assemble(x + 5.7e-4) == 1  # norm 9.9e-4
    assert reuse.assemble(x + 5.9e-4) == 2
    assert reuse.assemble(x + 5.7e-4) == 2
    assert reuse.saved == 3


def test_reset_forgets():
    fluid = Fluid()
    reuse = OperatorReuse(fluid, 1.0)
    reuse.assemble(np.zeros((1, 3)))
    reuse.reset()
    assert fluid.assembled[-1] == "reset"
    assert reuse.assemble(np.zeros((1, 3))) == 3
    assert reuse.saved == 0


def test_reach_is_a_share_of_the_traction_tolerance():
    """In a film p ~ H^-3; both sheets move."""
    d = reach(1e-3, 0.5, 0.3)
    assert (0.5 / (0.5 - 2.0 * d)) ** 3 - 1.0 == pytest.approx(0.3e-3, rel=1e-3)


def test_what_the_fluid_tells_of_its_operators_passes_through():
    fluid = Fluid()
    assert OperatorReuse(fluid, 1.0).statistics == {}
    fluid.statistics = {"rank_max": 7}
    assert OperatorReuse(fluid, 1.0).statistics is fluid.statistics  # it fills as the run goes
