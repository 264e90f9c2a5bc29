"""Welding, doubles, orientation and places of what cannot be mended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.figures import holes, mesh_quality
from cases.geometry.meshes.mending.topology import boundary_loops, edges_of
from cases.geometry.meshes.repair import repaired

from .written import bag, corners, signed_volume, soup, sphere


def flat_sheets(n: int = 4, apart: bool = True) -> FacetMesh:
    """Two flat sheets on an n x n lattice that lie on each other; own points, or one set."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([i, i + n + 1, i + n + 2, i + 1], axis=1)
    top = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    shift = len(points) if apart else 0
    triangles = np.concatenate([top, top[:, ::-1] + shift])
    points = np.concatenate([points, points]) if apart else points
    m = len(top)
    return FacetMesh(points, triangles, {"top": np.arange(m), "bottom": np.arange(m, 2 * m)})


def strip(turns: int, n: int = 12) -> FacetMesh:
    """A closed strip with half-turns: a Moebius strip for one."""
    t = 2 * np.pi * np.arange(n) / n
    sides = []
    for s in (-0.3, 0.3):
        r = 1 + s * np.cos(turns * t / 2)
        sides.append(np.stack([r * np.cos(t), r * np.sin(t), s * np.sin(turns * t / 2)], axis=1))
    after = (np.arange(n) + 1) % n
    a, b = np.arange(n), np.arange(n) + n
    c, d = np.where(after, after, turns % 2 * n), np.where(after, after + n, n - turns % 2 * n)
    triangles = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    return FacetMesh(np.concatenate(sides), triangles)


def test_a_jittered_soup_becomes_a_sphere() -> None:
    """5120 triangles, a third of them flipped, points off by 1e-7."""
    rng = np.random.default_rng(3)
    points, triangles = sphere(4)
    flipped = rng.random(len(triangles)) < 0.3
    triangles = np.where(flipped[:, None], triangles[:, ::-1], triangles)
    given = soup(FacetMesh(points, triangles))
    given = replace(given, points=given.points + rng.uniform(-1e-7, 1e-7, given.points.shape))
    mended = repaired(given)
    assert len(mended.points) == 2562
    assert len(mended.triangles) == 5120
    assert signed_volume(mended) == pytest.approx(4.17974, abs=1e-4)
    assert np.all(edges_of(mended.triangles).counts == 2)
    assert mended.notes == (
        "5120 triangles, 15360 points welded to 2562",
        f"{np.sum(flipped)} of 5120 triangles turned",
    )


@pytest.mark.parametrize("levels", [1, 2])
def test_inward_sheets_turn_with_middles_and_groups(levels: int) -> None:
    given = bag(levels)
    middles = given.points[given.triangles]
    middles = (middles + np.roll(middles, -1, axis=1)) / 2 * 1.01
    inward = replace(given, triangles=given.triangles[:, ::-1], middles=middles[:, [1, 0, 2]])
    mended = repaired(inward)
    assert np.array_equal(corners(mended, "inlet"), corners(given, "inlet"))
    assert mended.middles is not None
    ends = mended.points[mended.triangles]
    straight = (ends + np.roll(ends, -1, axis=1)) / 2
    assert np.abs(mended.middles - 1.01 * straight).max() < 1e-15


def test_sheets_that_lie_on_each_other_stay_two() -> None:
    """Only rims are welded; chords at two corners are halved, in each sheet by its own point."""
    given = flat_sheets()
    mended = repaired(given)
    edges = edges_of(mended.triangles)
    assert np.all(edges.counts == 2)
    assert len(mended.points) - len(edges.ends) + len(mended.triangles) == 2
    inner = 3 * 3
    assert len(mended.points) == 16 + 2 * inner + len(mended.triangles) // 2 - 32
    area = [
        np.linalg.norm(
            np.cross(*np.diff(mended.points[mended.triangles[own]], axis=1).transpose(1, 0, 2)),
            axis=1,
        ).sum()
        / 2
        for own in mended.groups.values()
    ]
    assert area == pytest.approx([16.0, 16.0])
    assert any("welded" in note for note in mended.notes)


def test_a_soup_of_coincident_sheets_needs_groups() -> None:
    given = soup(flat_sheets())
    mended = repaired(given)
    assert np.all(edges_of(mended.triangles).counts == 2)
    assert "sheets that lie on each other told apart by their groups" in mended.notes
    with pytest.raises(MeshError, match=r"two flat sheets of 32 triangles .* nothing tells them"):
        repaired(replace(given, groups={}))
    with pytest.raises(MeshError, match=r"32 triangles on the same three points in different"):
        repaired(flat_sheets(apart=False))


def test_doubles_and_unused_points_go() -> None:
    given = bag()
    m = len(given.triangles)
    doubled = replace(
        given,
        points=np.concatenate([given.points, [[9.0, 9.0, 9.0]]]),
        triangles=np.concatenate([given.triangles, given.triangles[:3], [[0, 0, 1]]]),
        groups={"film": given.groups["film"], "more": np.arange(m + 1)},
    )
    doubled = replace(doubled, groups={"all": np.arange(m + 4)})
    mended = repaired(doubled)
    assert np.array_equal(corners(mended), corners(given))
    text = "; ".join(mended.notes)
    assert "3 doubled triangles dropped, the first at (" in text
    assert "1 collapsed triangles dropped, the first at (" in text
    assert "1 points that no triangle uses left out" in text
    assert len(mended.groups["all"]) == m


def test_one_sided_sheets_are_named() -> None:
    with pytest.raises(MeshError, match=r"24 triangles has one side only .* edge from \(.*\) to"):
        repaired(strip(1))
    ring = repaired(strip(2))
    assert [len(loop) for loop in boundary_loops(ring.triangles)] == [12, 12]


def test_edges_of_three_triangles_are_named() -> None:
    given = bag()
    a, b = given.triangles[0, :2]
    wall = replace(
        given,
        points=np.concatenate([given.points, [[0.0, 0.0, 0.0]]]),
        triangles=np.concatenate([given.triangles, [[a, b, len(given.points)]]]),
        groups={**given.groups, "tether": np.array([len(given.triangles)])},
    )
    with pytest.raises(
        MeshError, match=r"1 edge\(s\) of three .* from \(.*\) to \(.*\) with 3 of .*tether"
    ):
        repaired(wall)


def test_components_are_listed_and_the_largest_kept() -> None:
    small, large = bag(), bag(2)
    points = np.concatenate([small.points / 2 + 5, large.points])
    both = FacetMesh(
        points,
        np.concatenate([small.triangles[:, ::-1], large.triangles + len(small.points)]),
        {"small": np.arange(80), "large": np.arange(80, 400)},
    )
    mended = repaired(both)
    assert signed_volume(mended) == pytest.approx(
        signed_volume(small) / 8 + signed_volume(large), rel=1e-12
    )
    assert mended.notes[-1].startswith("2 components: 320 triangles, area")
    kept = repaired(both, component="largest")
    assert np.array_equal(corners(kept), corners(large))
    assert set(kept.groups) == {"large"}


def test_surfaces_that_touch_in_a_point_get_two() -> None:
    given = bag()
    top = given.points[np.argmax(given.points[:, 2])]
    points = np.concatenate([given.points, 2 * top - given.points])
    both = FacetMesh(
        points, np.concatenate([given.triangles, given.triangles[:, ::-1] + len(given.points)])
    )
    mended = repaired(soup(both))
    assert len(mended.points) == 2 * len(given.points)
    assert any("1 points where surfaces only touch" in note for note in mended.notes)


def test_holes_have_length_and_centre() -> None:
    given = bag(2)
    open_bag = replace(given, triangles=given.triangles[given.groups["film"]], groups={})
    mended = repaired(replace(open_bag, triangles=open_bag.triangles[:, ::-1]))
    (hole,) = holes(mended.points, mended.triangles)
    rim = mended.points[hole.loop]
    assert hole.length == pytest.approx(np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum())
    assert hole.centre[2] < -0.25
    assert abs(hole.centre[0]) < 0.05
    assert np.array_equal(corners(mended), corners(open_bag))


def test_quality_names_the_sharpest() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1e-3, 0], [0.5, -1e-5, 0.0]], float)
    found = mesh_quality(points, np.array([[0, 1, 2], [0, 1, 3]]))
    assert found.smallest_angle == pytest.approx(np.degrees(1e-3), rel=1e-3)
    assert found.shortest == pytest.approx(1e-3)
    assert found.slivers == 1
    assert "the sharpest 0.057 at (0.6667, 0.0003333, 0)" in found.warnings()[0]


def test_a_weld_that_joins_everything_is_refused() -> None:
    points, triangles = sphere(5)
    given = soup(FacetMesh(points, triangles))
    with pytest.raises(MeshError, match="use a smaller weld"):
        repaired(given, weld=0.099)
    with pytest.raises(MeshError, match=r"geometry.weld = 2"):
        repaired(given, weld=2.0)
    with pytest.raises(MeshError, match=r"geometry.component"):
        repaired(given, component="smallest")


def test_short_edges_warn() -> None:
    given = bag()
    mended = repaired(given, weld=0.03)
    assert any(note.startswith("warning: the shortest edge") for note in mended.notes)


def test_triangles_without_height_are_turned() -> None:
    """A point on an edge, shared by a needle that closes the gap; two in a row; one on a rim."""
    given = bag()
    a, b, c = given.triangles[0].tolist()
    p, q = len(given.points), len(given.points) + 1
    x, y = given.points[a], given.points[b]
    points = np.concatenate([given.points, [x + (y - x) / 4, x + (y - x) / 2]])
    # triangle 0 becomes three, its neighbour across a b stays, needles lie between
    fan = [[a, p, c], [p, q, c], [q, b, c], [a, b, p], [p, b, q]]
    triangles = np.concatenate([given.triangles[1:], fan])
    groups = {"rest": np.arange(len(given.triangles) - 1), "fan": np.arange(79, 84)}
    mended = repaired(FacetMesh(points, triangles, groups))
    assert "2 triangles without height turned, the first at (" in "; ".join(mended.notes)
    assert np.all(edges_of(mended.triangles).counts == 2)
    assert mesh_quality(mended.points, mended.triangles).smallest_angle > 5
    assert signed_volume(mended) == pytest.approx(signed_volume(given), rel=1e-14)
    assert len(mended.groups["fan"]) == 3
    rim = FacetMesh(BENT_SQUARE, np.array([[0, 4, 3], [4, 1, 2], [4, 2, 3], [0, 1, 4]]))
    assert len(repaired(rim).triangles) == 3


BENT_SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0, 0]], float)


def test_a_needle_that_cannot_be_turned_is_named() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.3, 5e-6, 0]], float)
    with pytest.raises(MeshError, match=r"2 triangles lower than 1e-05, the first at \(0.5"):
        repaired(FacetMesh(points, np.array([[0, 1, 2], [1, 0, 3]])))


@pytest.mark.parametrize("seed", range(8))
def test_any_numbering_gives_the_same_surface(seed: int) -> None:
    """Points shared or not, in any order and number; triangles turned and rolled; curved edges."""
    rng = np.random.default_rng(seed)
    whole = bag(int(rng.integers(1, 4)))
    kept = np.sort(rng.permutation(len(whole.triangles))[: len(whole.triangles) - seed % 3])
    inlet = np.isin(kept, whole.groups["inlet"])
    groups = {"film": np.flatnonzero(~inlet), "inlet": np.flatnonzero(inlet)}
    ends = whole.points[whole.triangles[kept]]
    middles = (ends + np.roll(ends, -1, axis=1)) / 2 * 1.0625
    given = FacetMesh(whole.points, whole.triangles[kept], groups, middles)
    triangles = given.triangles.ravel().copy()
    alone = np.flatnonzero(rng.random(len(triangles)) < seed / 7)
    points = np.concatenate([given.points, given.points[triangles[alone]]])
    triangles[alone] = len(given.points) + np.arange(len(alone))
    order = rng.permutation(len(points))
    triangles = np.argsort(order)[triangles].reshape(-1, 3)
    points, turned = points[order], rng.random(len(triangles)) < 0.4
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    middles = np.where(turned[:, None, None], middles[:, [1, 0, 2]], middles)
    roll = (rng.integers(0, 3, len(triangles))[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, roll, axis=1)
    middles = np.take_along_axis(middles, roll[:, :, None], axis=1)
    points = points + rng.uniform(-1e-8, 1e-8, points.shape)
    mended = repaired(replace(given, points=points, triangles=triangles, middles=middles))
    used = len(np.unique(given.triangles))
    assert len(mended.points) == used
    for name in given.groups:
        own = given.points[given.triangles[given.groups[name]]]
        again = mended.points[mended.triangles[mended.groups[name]]]
        assert np.abs(corners_of(again) - corners_of(own)).max() < 4e-8
    ends = mended.points[mended.triangles]
    assert mended.middles is not None
    straight = (ends + np.roll(ends, -1, axis=1)) / 2
    assert np.abs(mended.middles - 1.0625 * straight).max() < 4e-8
    assert len(boundary_loops(mended.triangles)) == len(boundary_loops(given.triangles))


def corners_of(triangles: np.ndarray) -> np.ndarray:
    """Rounded corners first, so that points off by 1e-8 sort alike."""
    rounded = np.round(triangles, 6)
    rows = [(min(range(3), key=lambda k, t=t: t[k].tolist()), t) for t in rounded]
    exact = [np.roll(x, -k, axis=0).ravel() for (k, _), x in zip(rows, triangles, strict=True)]
    order = sorted(range(len(exact)), key=lambda i: np.round(exact[i], 6).tolist())
    return np.array([exact[i] for i in order])
