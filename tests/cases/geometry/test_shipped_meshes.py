"""Shipped mesh files are what their module writes, and what they claim to be."""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh
from cases.geometry.meshes.mesh_bag import mesh_bag
from cases.geometry.meshes.opening import opened
from cases.geometry.meshes.pattern import pattern_folding
from cases.geometry.meshes.reading import read_facets
from cases.geometry.meshes.repair import repaired
from cases.geometry.meshes.smoothing.curved_mesh import curved_mesh
from cases.scenes.meshes import round_bag
from cases.scenes.meshes.make import FILES, FOLDER
from cases.scenes.meshes.triangulation import smallest_angles


def mended(name: str) -> FacetMesh:
    return repaired(read_facets(FOLDER / name))


@pytest.mark.parametrize("name", FILES)
def test_files_are_what_is_written(name):
    stored = (FOLDER / name).read_bytes()
    assert stored == FILES[name]()
    assert len(stored) < 300_000
    facets = mended(name)
    edges = np.sort(
        np.stack([facets.triangles, np.roll(facets.triangles, -1, axis=1)], axis=2), axis=2
    )
    assert np.all(np.unique(edges.reshape(-1, 2), axis=0, return_counts=True)[1] == 2)


def test_every_file_has_its_generator():
    beside = {p.name for p in FOLDER.iterdir() if p.suffix not in (".py", "") and p.is_file()}
    assert beside == set(FILES)


def test_the_round_bag():
    raw, facets = read_facets(FOLDER / "bag.stl"), mended("bag.stl")
    points, triangles = round_bag.round_bag()
    assert len(raw.points) == 3 * len(triangles)
    assert len(facets.points) == len(points)
    assert f"{-(-len(triangles) // 3)} of {len(triangles)} triangles turned" in facets.notes
    assert smallest_angles(facets.points, facets.triangles).min() > 17.0  # 17.4
    # vertices lie on the pancake: distances from the circles and planes of its meridian
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    rim, neck = np.abs(np.hypot(r - 9, z - 2) - 1), np.abs(np.hypot(r - 2, z) - 1)
    planes = [np.abs(z - 3), np.abs(z - 1), np.abs(z)]
    assert np.minimum.reduce([rim, neck, *planes]).max() < 1e-12
    mesh = curved_mesh(facets, crease=55.0)
    unit = round_bag.UNIT**3
    assert mesh.volume / unit / round_bag.BODY.volume == pytest.approx(1.0, abs=5e-4)  # -2.8e-4
    assert mesh.facet_volume / unit / round_bag.BODY.volume == pytest.approx(0.970, abs=1e-3)


def test_the_disc_deck():
    raw = read_facets(FOLDER / "disc.k")
    assert list(raw.groups) == ["Airbag upper", "Airbag lower", "Inflator"]
    assert np.all(raw.points[:, 2] == 0.0)
    angles = smallest_angles(raw.points, raw.triangles)
    assert 8.0 < angles.min() < 15.0  # 11.4: narrow triangles of the trimmed rim
    bag = opened(mended("disc.k"), 4.0)
    a, b, c = bag.points[bag.triangles].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    radius = np.hypot(*bag.reference[:, :2].T).max()
    assert volume == pytest.approx(8.0 * np.pi * radius**2, rel=0.1)
    inlet = bag.triangles[bag.groups["Inflator"]]
    assert np.ptp(np.sign(bag.points[inlet, 2])) == 0.0
    assert bag.notes[-1].startswith("sheets opened by 4")
    # the seam's wedge does not count as a narrow place
    assert 6.0 < mesh_bag(bag, inlet="Inflator", degree=2).narrowest < 8.0


def test_the_flat_pattern():
    facets = mended("pattern.obj")
    assert 2200 < len(facets.triangles) < 2500
    assert smallest_angles(facets.points, facets.triangles).min() > 19.0  # 19.5
    low, high = facets.points.min(axis=0), facets.points.max(axis=0)
    np.testing.assert_allclose(high - low, [1.0, 0.5, 0.01], atol=1e-4)
    inlet = facets.triangles[facets.groups["inlet"]]
    assert np.all(facets.points[inlet, 2] == -0.005)
    folds = [(0.36, "up", 0.025), (0.66, "down", 0.025)]
    folding = pattern_folding(folds, (1.0, 0.0, 0.0), facets.points)
    flat = folding.maps[0](facets.points)
    corners = flat[inlet]
    assert corners[:, :, 0].max() < folding.panels[0][1]
    folded = folding.maps[1](flat)
    t = facets.triangles
    volume = [np.einsum("ij,ij->", p[t[:, 0]], np.cross(p[t[:, 1]], p[t[:, 2]])) / 6.0
              for p in (flat, folded)]  # fmt: skip
    # straight triangles cut the bends short: 4 % of the volume
    assert volume[1] == pytest.approx(volume[0], rel=0.06)
