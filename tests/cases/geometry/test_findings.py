"""What is said of a mesh before it runs: slivers, seams, thin and coincident sheets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh
from cases.geometry.meshes.findings import findings
from cases.geometry.meshes.opening import double_sheet, opened
from cases.geometry.meshes.smoothing.curved_mesh import curved_mesh


def box(n: int, height: float) -> FacetMesh:
    """A flat box 1 x 1 x height of n x n x 1 cells, closed, outward."""
    x = np.arange(n + 1) / n
    sheet = np.array([[a, b] for a in x for b in x])
    corner = np.array([i * (n + 1) + j for i in range(n) for j in range(n)])[:, None]
    steps = (np.array([0, n + 1, 1]), np.array([n + 2, 1, n + 1]))
    top = np.concatenate([corner + s for s in steps])
    bottom = top[:, [0, 2, 1]] + sheet.shape[0]
    grid = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    loop = np.concatenate([grid[:-1, 0], grid[-1, :-1], grid[:0:-1, -1], grid[0, :0:-1]])
    a, b = loop, np.roll(loop, -1)
    low, high = a + sheet.shape[0], b + sheet.shape[0]
    sides = np.concatenate([np.stack([a, low, b], 1), np.stack([b, low, high], 1)])
    points = np.concatenate(
        [np.column_stack([sheet, np.full(len(sheet), z)]) for z in (height, 0.0)]
    )
    return FacetMesh(points, np.concatenate([top, bottom, sides]))


def texts(found) -> str:
    return "\n".join(f.text for f in found)


def test_a_flat_box():
    found = findings(box(6, 0.05))
    assert not any(f.warns for f in found)
    # 2 V / A = 0.1 / 2.2, extent sqrt(2.2 / 2 pi)
    assert "2 V / A = 0.0455, 0.038 of the extent; narrowest 0.05 at" in texts(found)
    assert "smallest angle 16.7 degrees" in texts(found)
    assert "edges 0.05 to 0.236" in texts(found)
    assert "turn back" not in texts(found)


def test_thin_and_coincident_sheets_are_told_with_the_remedy():
    thin = findings(box(6, 0.004))
    (warning,) = [f.text for f in thin if f.text.startswith("thinness 0.0035: ")]
    assert "2e+05 times larger" in warning
    flat = box(6, 0.0)
    sheet = replace(flat, triangles=flat.triangles[:72], points=flat.points[:49])
    bag = double_sheet(sheet)
    (warning,) = [f for f in findings(bag) if f.warns]
    assert warning.text.startswith("sheets coincide")
    assert "set geometry.opening" in warning.text
    lifted = findings(opened(bag, 0.03))
    assert not any(f.warns for f in lifted)
    (line,) = [f for f in lifted if "2 V / A" in f.text]
    assert "narrowest, away from seams, 0.0" in line.text
    assert not len(line.places)
    assert "24 edges turn back by more than 120 degrees" in texts(lifted)


def test_pinched_places_are_marked():
    bag = box(12, 0.1)
    points = bag.points.copy()
    dent = np.hypot(points[:, 0] - 0.25, points[:, 1] - 0.75) < 0.2
    points[dent & (points[:, 2] > 0.0), 2] = 0.02
    found = [f for f in findings(replace(bag, points=points)) if "2 V / A" in f.text]
    assert "narrowest, away from seams, 0.02 at (0." in found[0].text
    assert "of the area faces a sheet within half of it" in found[0].text
    assert len(found[0].places)
    assert np.all(np.hypot(found[0].places[:, 0] - 0.25, found[0].places[:, 1] - 0.75) < 0.3)


def test_slivers_are_marked_where_they_are():
    bag = box(4, 0.5)
    points = bag.points.copy()
    k = int(np.flatnonzero(np.all(points == [0.5, 0.5, 0.5], axis=1))[0])
    points[k] = [0.745, 0.5, 0.5]
    found = [f for f in findings(replace(bag, points=points)) if f.warns]
    assert len(found) == 1
    assert "angle below 5 degrees" in found[0].text
    np.testing.assert_allclose(found[0].places, [[0.75, 0.5, 0.5]] * len(found[0].places), atol=0.1)
    assert 2 <= len(found[0].places) <= 4


def test_curved_meshes_and_open_ones():
    bag = box(6, 0.3)
    curved = findings(curved_mesh(bag, crease=120.0))
    assert "2 V / A" in texts(curved)
    volume = float(texts(curved).split("2 V / A = ")[1].split(",")[0])
    assert volume == pytest.approx(2 * curved_mesh(bag, crease=120.0).volume
                                   / curved_mesh(bag, crease=120.0).area, rel=1e-2)  # fmt: skip
    sheet = findings(replace(bag, triangles=bag.triangles[:72]))
    assert "2 V / A" not in texts(sheet)
