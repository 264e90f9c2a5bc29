"""Contact pressure and zones on the grids of a bag."""

import numpy as np
import pytest

from cases.geometry.bag_fields import BagFields, ContactLoad, Zones
from cases.geometry.bag_sampler import BagSampler, triangulated
from cases.geometry.folded import folded_bag
from cases.geometry.folding import flat
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


def test_cells_take_the_state_of_the_nearest_point(bag):
    """Points (1/6, 1/2, 5/6)^2: with three cells a side each has its own; the inlet is taut."""
    x = (np.arange(3) + 0.5) / 3.0
    points = np.stack([g.ravel() for g in np.meshgrid(x, x, indexing="ij")])
    n = bag.membrane.n_elements
    state = np.random.default_rng(0).integers(0, 3, (n, 9))
    fields = BagFields(BagSampler(bag), zones=Zones(points, lambda c: state))
    found = fields.surface_grid(bag.coefficients)["cell_data"]["wrinkling"]
    np.testing.assert_array_equal(found[: 9 * n], state.ravel())
    assert not found[9 * n :].any()
    coarse = fields.surface_grid(bag.coefficients, tessellate=1)["cell_data"]["wrinkling"]
    np.testing.assert_array_equal(coarse[:n], state[:, 4])
