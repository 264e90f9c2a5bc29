"""Coincident sheets told apart, chords of the seam split, and room made between the sheets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.flat.chords import split_chords
from cases.geometry.meshes.flat.plane import fitted_plane
from cases.geometry.meshes.flat.sheets import told_apart
from cases.geometry.meshes.mending.bisection import bisected
from cases.geometry.meshes.opening import double_sheet, opened, stretches

N = 8


def square(n: int = N) -> FacetMesh:
    """A unit square of two triangles a cell: chords cut off two of its corners."""
    x = np.arange(n + 1) / n
    points = np.array([[a, b, 0.0] for a in x for b in x])
    corners = np.array([i * (n + 1) + j for i in range(n) for j in range(n)])[:, None]
    triangles = np.concatenate(
        [corners + np.array([0, n + 1, 1]), corners + np.array([n + 2, 1, n + 1])]
    )
    return FacetMesh(points, triangles, {"inlet": np.arange(3 * n, 3 * n + 4)})


def volume(facets: FacetMesh) -> float:
    a, b, c = facets.points[facets.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def uses(facets: FacetMesh) -> np.ndarray:
    """Triangles at each edge."""
    t = facets.triangles
    edges = np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1]


def middled(facets: FacetMesh) -> FacetMesh:
    t = facets.triangles
    return replace(facets, middles=0.5 * (facets.points[t] + facets.points[np.roll(t, -1, axis=1)]))


def test_sheets_are_told_apart_whatever_the_orientation():
    bag = double_sheet(square())
    m = bag.triangles.shape[0] // 2
    turned = bag.triangles.copy()
    turned[::3] = turned[::3][:, [1, 0, 2]]
    sheets = told_apart(replace(bag, triangles=turned))
    assert set(sheets.upper[:m]) != set(sheets.upper[m:])
    assert len(set(sheets.upper[:m])) == len(set(sheets.upper[m:])) == 1
    assert sheets.seam.shape == (4 * N, 2)
    assert sheets.open_edges.size == 0


def test_chords_of_both_sheets_are_split_in_each_sheet():
    bag = double_sheet(square())
    # both corner triangles are the same three points twice, and both chords have four triangles
    split = split_chords(bag)
    assert uses(bag).max() == 4
    assert set(uses(split)) == {2}
    assert split.triangles.shape[0] == bag.triangles.shape[0] + 8
    assert split_chords(split) is split
    assert "4 edges" in split.notes[-1]
    areas = [0.5 * np.linalg.norm(np.cross(*(b.points[b.triangles[g]][:, [1, 2]]
             - b.points[b.triangles[g]][:, [0]]).transpose(1, 0, 2)), axis=1).sum()
             for b, g in ((bag, bag.groups["inlet"]), (split, split.groups["inlet"]))]  # fmt: skip
    assert areas[1] == pytest.approx(areas[0], rel=1e-14)


def test_groups_tell_which_corners_belong_together():
    """Corners beyond a chord of four triangles hang on it alone; their groups join them."""
    bag = double_sheet(square())
    m = bag.triangles.shape[0] // 2
    for swapped in (False, True):
        t = bag.triangles.copy()
        if swapped:  # the first corner's two triangles change places in the list
            k = 0
            t[[k, m + k]] = t[[m + k, k]]
        parts = {"one": np.arange(m), "two": np.arange(m, 2 * m)}
        sheets = told_apart(replace(bag, triangles=t, groups=parts))
        assert len(set(sheets.upper[:m])) == 1


def test_opened_square():
    h = 0.02
    bag = opened(double_sheet(square()), h, drawn=False)
    assert set(uses(bag)) == {2}
    runs = np.stack([bag.triangles, np.roll(bag.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    assert np.unique(runs, axis=0).shape == runs.shape
    assert volume(bag) > 0.0
    np.testing.assert_array_equal(bag.reference[:, 2], 0.0)
    np.testing.assert_array_equal(bag.reference[:, :2], bag.points[:, :2])
    x, y, z = bag.points.T
    d = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    exact = h * np.sqrt(1.0 - np.maximum(1.0 - d / (2.0 * h), 0.0) ** 2)
    np.testing.assert_allclose(np.abs(z), exact, atol=1e-15)
    # every triangle has a point off the seam, and each sheet keeps to its side
    corners = z[bag.triangles]
    assert np.all(np.abs(corners).max(axis=1) > 0.0)
    assert np.all((corners >= 0.0).all(axis=1) | (corners <= 0.0).all(axis=1))
    # rows at the rim are stretched by about (h / size)^2 / 2 = 1.3 %
    assert "stretches it by 1 to 1.0" in bag.notes[-1]


def test_sheets_are_drawn_in():
    """A disc on narrow rings: lifted by their width, its rim is stretched by a quarter."""
    radii, n = np.array([1.0, 0.97, 0.9, 0.7, 0.4]), 48
    angle = 2.0 * np.pi * (np.arange(n) + 0.5 * np.arange(len(radii))[:, None]) / n
    rings = np.stack([radii[:, None] * f(angle) for f in (np.cos, np.sin)], axis=2).reshape(-1, 2)
    points = np.column_stack([np.concatenate([rings, [[0.0, 0.0]]]), np.zeros(len(rings) + 1)])
    a, b = np.arange(n), (np.arange(n) + 1) % n
    strips = [np.concatenate([np.stack([a, b, a + n], 1), np.stack([b, b + n, a + n], 1)]) + n * k
              for k in range(len(radii) - 1)]  # fmt: skip
    last = n * (len(radii) - 1)
    cap = np.stack([a + last, b + last, np.full(n, last + n)], axis=1)
    flat = double_sheet(middled(FacetMesh(points, np.concatenate([*strips, cap]))))
    stiff, soft = opened(flat, 0.03, drawn=False), opened(flat, 0.03)
    np.testing.assert_allclose(soft.points[:, 2], stiff.points[:, 2], atol=1e-15)
    before, after = (stretches(b.reference, b.points, b.triangles) for b in (stiff, soft))
    assert before.max() > 1.25
    # a rim drawn in by s shortens its circle by s: what is left is shared by both
    assert np.abs(after - 1.0).max() < 0.08
    rim = np.hypot(*soft.points[:n, :2].T)
    assert np.ptp(rim) < 1e-6
    assert 0.005 < 1.0 - rim.mean() < 0.015
    ends = 0.5 * (soft.points[soft.triangles] + soft.points[np.roll(soft.triangles, -1, axis=1)])
    np.testing.assert_allclose(soft.middles[:, :, :2], ends[:, :, :2], atol=1e-12)


def test_volume_of_an_opened_square_converges_to_its_profile():
    h, n = 0.2, 24
    errors = []
    # slices of area (1 - 2 d)^2 at height z(d): V = 2 int_0^w z'(d) (1 - 2 d)^2 dd
    d, weight = np.polynomial.legendre.leggauss(200)
    angle = 0.25 * np.pi * (d + 1.0)  # d = w (1 - cos angle), z = h sin angle
    inside = (1.0 - 4.0 * h * (1.0 - np.cos(angle))) ** 2
    exact = 2.0 * h * 0.25 * np.pi * (weight * np.cos(angle)) @ inside
    for k in (n, 2 * n):
        errors.append(abs(volume(opened(double_sheet(square(k)), h, drawn=False)) / exact - 1.0))
    assert errors[1] < 0.4 * errors[0]
    assert errors[1] < 1e-2


def test_middles_and_orientation_follow():
    flat = middled(double_sheet(square()))
    bag = opened(flat, 0.04, drawn=False)
    t = bag.triangles
    height = np.abs(bag.middles[:, :, 2])
    x, y = bag.middles[:, :, 0], bag.middles[:, :, 1]
    d = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    np.testing.assert_allclose(
        height, 0.04 * np.sqrt(1.0 - np.maximum(1.0 - d / 0.08, 0.0) ** 2), atol=1e-14
    )
    ends = 0.5 * (bag.points[t] + bag.points[np.roll(t, -1, axis=1)])
    np.testing.assert_allclose(bag.middles[:, :, :2], ends[:, :, :2], atol=1e-14)
    wrong = flat.triangles.copy()
    wrong[5] = wrong[5][[0, 2, 1]]
    turned = flat.middles.copy()
    turned[5] = turned[5][::-1]
    again = opened(replace(flat, triangles=wrong, middles=turned), 0.04, drawn=False)
    np.testing.assert_array_equal(again.triangles, bag.triangles)
    np.testing.assert_array_equal(again.middles, bag.middles)


def test_curved_second_order_triangles_are_split_on_their_surface():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    middles = np.array([[[0.5, 0, 0.25], [0.5, 0.5, 0.5], [0, 0.5, 0.25]]])  # z = x - x^2 + y - y^2
    one = FacetMesh(points, np.array([[0, 1, 2]]), {"a": np.array([0])}, middles)
    for marked in ([1, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 1]):
        split, parents = bisected(one, np.array([marked], dtype=bool))
        assert split.triangles.shape[0] == 1 + sum(marked)
        assert parents.tolist() == [0] * (1 + sum(marked))
        for found in (split.points, split.middles.reshape(-1, 3)):
            x, y, z = found.T
            np.testing.assert_allclose(z, x - x**2 + y - y**2, atol=1e-15)
        a, b, c = split.points[split.triangles].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)[:, 2]
        assert np.all(normals > 0.0)
        assert normals.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(
            split.middles[:, :, :2],
            0.5
            * (split.points[split.triangles] + split.points[np.roll(split.triangles, -1, 1)])[
                :, :, :2
            ],
            atol=1e-15,
        )


def test_a_folded_bag_opens_along_its_own_normals():
    """Bent into a quarter of a cylinder, unfolded in its reference."""
    flat = double_sheet(square())
    radius = 2.0 / np.pi
    angle = flat.points[:, 0] / radius
    bent = np.column_stack(
        [radius * np.sin(angle), flat.points[:, 1], radius * (1.0 - np.cos(angle))]
    )
    bag = opened(replace(flat, points=bent, reference=flat.points), 0.02)
    # points of the file: those that split chords lie on facets
    given = np.arange(bag.points.shape[0]) < flat.points.shape[0]
    off = np.hypot(bag.points[:, 0], bag.points[:, 2] - radius) - radius
    inside = given & (np.abs(bag.reference[:, :2] - 0.5).max(axis=1) < 0.45)
    np.testing.assert_allclose(np.abs(off[inside]), 0.02, rtol=1e-12)
    assert (off[inside] > 0.0).sum() == (N - 1) ** 2
    np.testing.assert_array_equal(bag.reference[:, 2], 0.0)


def test_the_plane_lies_between_sheets_of_unequal_meshes():
    rng = np.random.default_rng(1)
    upper = np.column_stack([rng.uniform(0, 1, (100, 2)), np.full(100, 0.01)])
    lower = np.column_stack([rng.uniform(0, 1, (900, 2)) ** 3, np.full(900, -0.01)])
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (-0.01, 0.01)])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    plane = fitted_plane(np.concatenate([upper, lower, corners]) @ turn.T)
    assert abs(plane.axes[2] @ turn[:, 2]) == pytest.approx(1.0, abs=1e-12)
    assert plane.thickness == pytest.approx(0.02, rel=1e-9)
    np.testing.assert_allclose(plane.axes @ plane.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(plane.axes) == pytest.approx(1.0)


def test_sheets_a_little_apart_are_laid_together():
    """As decks have them that give each sheet a height of its own."""
    bag = double_sheet(square())
    points = bag.points.copy()
    rim = np.abs(points[:, :2] - 0.5).max(axis=1) == 0.5
    copy = np.arange(len(points)) >= (N + 1) ** 2
    points[:, 2] = np.where(copy & ~rim, -0.002, 0.002)
    apart = opened(replace(bag, points=points), 0.02)
    assert "sheets up to 0.004 apart laid into one plane" in "\n".join(apart.notes)
    flat = opened(bag, 0.02)
    np.testing.assert_allclose(apart.points[:, :2], flat.points[:, :2], atol=1e-12)
    np.testing.assert_allclose(apart.points[:, 2], flat.points[:, 2], atol=1e-12)


def test_what_cannot_be_opened():
    sheet = square()
    bag = double_sheet(sheet)
    with pytest.raises(MeshError, match="one with an open rim: double it"):
        opened(sheet, 0.02)
    with pytest.raises(MeshError, match="opening = 0: half the distance"):
        opened(bag, 0.0)
    with pytest.raises(MeshError, match=r"use at most 0\.25"):
        opened(bag, 0.3)
    bent = bag.points + [[0, 0, 0.1]] * (bag.points[:, :1] > 0.4)
    with pytest.raises(MeshError, match=r"lie on each other: the mesh is 0\.079 thick over 1"):
        opened(replace(bag, points=bent), 0.02)
    with pytest.raises(MeshError, match=r"the unfolded reference is 0\.079 thick"):
        opened(replace(bag, reference=bent), 0.2)
    with pytest.raises(MeshError, match=r"sheets do not coincide: the mesh is 0\.079 thick over 1"):
        split_chords(replace(bag, points=bent))
    with pytest.raises(MeshError, match="only a single flat sheet"):
        double_sheet(bag)
    with pytest.raises(MeshError, match=r"3 triangles meet at one edge.*at the edge from \(0"):
        opened(replace(bag, triangles=np.concatenate([bag.triangles, bag.triangles[1:2]])), 0.02)
    empty = np.concatenate([sheet.triangles, [[0, 1, 2]]])
    with pytest.raises(MeshError, match="1 triangles of a flat sheet have no area"):
        opened(replace(sheet, triangles=empty), 0.02)
