"""A bag of triangles: samples for contact, curved cells in files, flat pieces in pictures."""

import numpy as np
import pytest

from cases.geometry.bag_sampler import BagSampler, element_areas, triangulated
from cases.geometry.inspection import faced
from cases.geometry.wrinkles import ClothSampler
from cases.kinds.inflation.forecast import volume
from cases.kinds.inflation.views.mesh_check import Spot, mesh_picture
from cases.kinds.inflation.views.picture import enclosed_volume
from cases.output.vtk import flat_cells_of, read_grid, write_grid

from .triangle_bags import spheroid


@pytest.fixture(scope="module")
def bag():
    return spheroid()


def test_samples_close_the_bag(bag):
    """Membrane and inlet share their rim's samples: every edge has two triangles."""
    mesh = triangulated(bag, 3)
    elements = sum(part.n_elements for part in bag.parts)
    assert len(mesh.triangles) == 9 * elements
    assert np.array_equal(np.unique(mesh.cells // 9), np.arange(elements))
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    assert not mesh.intersects(bag.coefficients)
    flat = bag.coefficients * [1.0, 1.0, -1.0]  # inside out: nothing crosses, either
    assert not mesh.intersects(flat)


def test_areas_and_volume(bag):
    errors = [abs(volume(b) / b.exact_volume - 1.0) for b in (bag, spheroid(480))]
    assert errors[0] < 2e-4
    assert errors[1] < errors[0] / 10.0  # fourth order and more in the size
    fine = spheroid(480)
    area = sum(
        element_areas(part, c).sum()
        for part, c in zip(fine.parts, BagSampler(fine).split(fine.coefficients), strict=True)
    )
    eccentricity = np.sqrt(0.75)
    exact = 2.0 * np.pi * (1.0 + 0.25 / eccentricity * np.arctanh(eccentricity))
    assert area == pytest.approx(exact, rel=5e-3)  # one point an element
    assert faced(bag) == np.inf


def test_curved_cells_in_files(bag, tmp_path):
    rng = np.random.default_rng(1)
    traction = rng.standard_normal((sum(part.n_dofs for part in bag.parts), 3))
    grid = BagSampler(bag).surface_grid(bag.coefficients, traction)
    write_grid(tmp_path / "bag.vtu", grid)
    mesh = read_grid(tmp_path / "bag.vtu")
    assert mesh.cells[0].type == "VTK_LAGRANGE_TRIANGLE"
    cells = mesh.cells[0].data
    assert cells.shape == (sum(part.n_elements for part in bag.parts), 10)
    # vertices come first and carry their own density
    corner = mesh.point_data["traction"][cells[: bag.membrane.n_elements, :3]]
    assert np.allclose(corner, traction[bag.membrane.triangles], atol=1e-14)
    assert np.array_equal(np.bincount(mesh.cell_data["part"][0]), [p.n_elements for p in bag.parts])
    pieces = flat_cells_of(mesh)
    assert pieces.corners.shape == (9 * len(cells), 4)
    assert np.array_equal(pieces.values(mesh, "part"), np.repeat(mesh.cell_data["part"][0], 9))
    assert enclosed_volume(mesh.points, pieces.corners) == pytest.approx(bag.exact_volume, rel=1e-2)


def test_wrinkles_by_triangle(bag):
    sampler = ClothSampler(bag, bag.coefficients[: bag.n_membrane], 0.3)
    grid = sampler.surface_grid(bag.coefficients * [1.1, 0.8, 1.0])
    part, zones = (grid["cell_data"][k] for k in ("part", "wrinkling"))
    assert zones.shape == part.shape
    assert (zones[part == 1] == 0).all()
    assert np.bincount(zones[part == 0], minlength=3)[1] > 0.5 * bag.membrane.n_elements


def test_picture_of_a_check(bag, tmp_path):
    marks = [Spot("here", bag.coefficients[3])]
    assert mesh_picture(bag, tmp_path / "check.png", marks).stat().st_size > 20_000
