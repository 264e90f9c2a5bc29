"""The locking forecast within a factor of two of computed roofs, and its warning."""

import pytest

from cases import loader
from cases.benchmarks.shells.roof import roof
from cases.kinds.inflation import forecast as preflight
from cases.kinds.inflation.initial_bag import initial_bag
from cases.kinds.locking import locking_parameter, loss


@pytest.mark.parametrize(("degree", "membrane", "n"), [(2, "gauss", 12), (3, "gauss", 12)])
def test_forecast_at_a_roof_it_was_not_made_from(degree, membrane, n):
    thickness, arc, radius = 0.025, 34.9, 25.0
    exact = roof(16, 5, thickness=thickness, membrane="reduced")[0]
    lost = 1.0 - roof(n, degree, thickness=thickness, membrane=membrane)[0] / exact
    forecast = loss((arc / n) ** 2 / (radius * thickness), degree, membrane)
    assert 0.5 < forecast / lost < 2.0


def test_check_warns_in_the_locked_regime_only():
    def warnings(*keys):
        found = preflight.forecast(loader.read("pancake", keys)).warnings
        return [w for w in found if "membrane locking" in w]

    assert warnings() == []
    (quadratic,) = warnings("mesh.degree=2")
    assert "mesh.degree = 3" in quadratic
    (thin,) = warnings("structure.flexural_rigidity=1e-4")
    assert "structure.membrane = 'reduced'" in thin
    assert warnings("structure.flexural_rigidity=1e-4", "structure.membrane=reduced") == []


def test_parameter_falls_with_the_elements_around():
    bags = [initial_bag(loader.read("pancake", [f"mesh.around={n}"])) for n in (12, 24)]
    (coarse, size), (fine, _) = (locking_parameter(bag, 0.1) for bag in bags)
    assert size == pytest.approx(2.0 * 3.1416 * 10.0 / 12, rel=0.05)
    # not by 4: the finest rings leave other elements as the largest
    assert 3.0 < coarse / fine < 4.2
