"""Contact pressure on the grids of a bag."""

import numpy as np
import pytest

from cases.geometry.bag_fields import BagFields, ContactLoad
from cases.geometry.bag_sampler import BagSampler, triangulated
from cases.geometry.folding import flat, roll_folding
from cases.geometry.pillows.folded import folded_bag
from shells.surfaces.pillow import Pillow

THIN = 1e-3  # distance of the sheets, a hundredth of the elements


@pytest.fixture(scope="module")
def bag():
    return folded_bag(Pillow(16, 8), flat(THIN))


@pytest.mark.parametrize("cells", [2, 3, 5])
def test_contact_pressure_stays_on_its_sheet(bag, cells):
    """The contact's mesh has three cells a side; of the other sheet nothing comes over."""
    mesh = triangulated(bag, 3)

    def pressure(coefficients):
        x, _, z = (mesh.sample @ coefficients).T
        return np.where(z > 0.0, 1.0 + x, -1.0 - x)

    sampler = BagSampler(bag)
    grid = BagFields(sampler, contact=ContactLoad(mesh, pressure)).surface_grid(
        bag.coefficients, tessellate=cells
    )
    (x, _, z), found = grid["points"].T, grid["point_data"]["contact_pressure"]
    middle = np.abs(z) > 0.4 * THIN
    assert middle.sum() > 0.3 * len(z)
    assert (np.sign(found) == np.sign(z))[middle].all()
    off = np.abs(np.abs(found) - 1.0 - x)[middle].max()
    assert off < (1e-12 if cells == 3 else 0.06)


@pytest.mark.parametrize("cells", [3, 2])
def test_turns_of_a_roll_are_told_apart(cells):
    """Every point reads the pressure of its own place in the flat bag, not of the next turn."""
    rolled = folded_bag(Pillow(36, 30), roll_folding(2.0, 1.0, 0.4))
    mesh, sampler = triangulated(rolled, 3), BagSampler(rolled)
    fields = BagFields(sampler, ContactLoad(mesh, lambda c: (mesh.sample @ rolled.flat)[:, 0]))
    grid = fields.surface_grid(rolled.coefficients, tessellate=cells)
    flat = sampler.surface_grid(rolled.flat, tessellate=cells)["points"]
    off = np.abs(grid["point_data"]["contact_pressure"] - flat[:, 0]).max()
    assert off < (1e-12 if cells == 3 else 0.03)
