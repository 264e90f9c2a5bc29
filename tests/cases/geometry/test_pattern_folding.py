"""A flat pattern folded by one planar curve: where it comes to lie, and what is refused."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cases.geometry.folding import accordion_folding
from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.pattern import HalfTurn, pattern_folding

GAP = 0.01
FOLDS = [
    {"at": 0.66, "side": "down", "radius": 0.025},
    {"at": 0.36, "side": "up", "radius": 0.025},
]
X = (1.0, 0.0, 0.0)


def pattern(n: int = 100) -> tuple[np.ndarray, np.ndarray]:
    """Two sheets 1 x 0.5 on lattices, not joined: points and triangles."""
    x = np.array([[i / n, j / n, 0.0] for i in range(n + 1) for j in range(n // 2 + 1)])
    m = n // 2 + 1
    corner = np.array([i * m + j for i in range(n) for j in range(n // 2)])[:, None]
    t = np.concatenate([corner + np.array([0, m, 1]), corner + np.array([m + 1, 1, m])])
    half = np.array([0.0, 0.0, 0.5 * GAP])
    points = np.concatenate([x + half, x - half])
    return points, np.concatenate([t, t[:, [0, 2, 1]] + x.shape[0]])


def test_two_folds_of_a_pattern_anywhere_in_space():
    points, triangles = pattern()
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn) * np.array([1.0, 1.0, 1.0])
    moved = points @ turn.T + [3.0, -2.0, 5.0]
    folding = pattern_folding(FOLDS, 2.0 * turn[:, 0], moved)
    flat = folding.maps[0](moved)
    up = 1.0 if turn[np.abs(turn[:, 2]).argmax(), 2] > 0 else -1.0
    np.testing.assert_allclose(flat, points * [1, up, up] - [0, 0.25 * up, 0], atol=1e-12)
    folded = folding.maps[1](flat)
    first = flat[:, 0] <= folding.panels[0][1]
    np.testing.assert_array_equal(folded[first], flat[first])
    heights = [folded[(flat[:, 0] > a) & (flat[:, 0] < b), 2] for a, b in folding.panels]
    for k, z in enumerate(heights):
        np.testing.assert_allclose(np.abs(z - 0.05 * k), 0.5 * GAP, atol=1e-12)
    # the curve's ends: 0.36 - 0.30 + 0.34 along, as bends have no extent in sum
    assert folded[np.abs(flat[:, 0] - 1.0) < 1e-9, 0] == pytest.approx(0.40)
    assert folding.gap == pytest.approx(GAP)
    assert folding.between == pytest.approx(0.05 - GAP)
    assert folding.bending == pytest.approx(0.2)
    assert folding.squared_curvature == pytest.approx(2 * np.pi / 0.025)
    # stretches are 1 -+ gap / (2 radius) on the bends, 1 elsewhere
    cut, whole = folded[triangles], flat[triangles]
    along = np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1) / np.linalg.norm(
        whole[:, 1] - whole[:, 0], axis=1
    )
    assert along.max() == pytest.approx(1.2, abs=2e-2)
    assert np.quantile(along, 0.01) == pytest.approx(0.8, abs=2e-2)
    assert np.median(along) == pytest.approx(1.0, abs=1e-12)


def test_an_accordion_is_the_same_as_before():
    known = accordion_folding(2, 6.0, 0.4)
    points, _ = pattern()
    points[:, 2] *= known.gap / GAP
    folds = [
        HalfTurn(known.panel * (k + 1), side, known.radius) for k, side in enumerate(["up", "down"])
    ]
    folding = pattern_folding(folds, X, points)
    np.testing.assert_allclose(folding.panels, known.panels, atol=1e-12)
    for name in ("gap", "radius", "between", "panel", "inlet", "squared_curvature"):
        assert getattr(folding, name) == pytest.approx(getattr(known, name), rel=1e-9)
    flat = folding.maps[0](points)
    np.testing.assert_allclose(folding.maps[1](flat), known.maps[0](flat), atol=1e-12)


def test_a_tuck_needs_a_smaller_inner_radius():
    points, _ = pattern(20)
    letter = [(0.33, "up", 0.05), (0.7, "up", 0.02)]
    folding = pattern_folding(letter, X, points)
    # panels at 0, 0.1 and 0.1 - 0.04
    assert folding.between == pytest.approx(0.04 - GAP)
    with pytest.raises(MeshError, match=r"layers at .* along the pattern come within .*alternate"):
        pattern_folding([(0.33, "up", 0.025), (0.7, "up", 0.025)], X, points)
    with pytest.raises(MeshError, match="layers"):  # the inner panel runs into the first bend
        pattern_folding([(0.33, "up", 0.05), (0.6, "up", 0.02)], X, points)
    with pytest.raises(MeshError, match="layers"):  # a third fold to the same side hits both
        pattern_folding([(0.2, "up", 0.02), (0.4, "down", 0.02), (0.7, "down", 0.03)], X, points)


def test_thickness_decides_whether_layers_meet():
    points, _ = pattern(20)
    folds = [(0.33, "up", 0.05), (0.72, "up", 0.044)]  # panels at 0, 0.1 and 0.012
    assert pattern_folding(folds[:1], X, points).between == pytest.approx(0.1 - GAP)
    assert pattern_folding(folds, X, points).between == pytest.approx(0.012 - GAP)
    with pytest.raises(MeshError, match=r"0\.012 of each other, and the bag is 0\.02 thick"):
        pattern_folding(folds, X, points, gap=0.02)


@pytest.mark.parametrize(
    ("folds", "along", "words"),
    [
        ([], X, "one fold at least"),
        ([(0.3, "left", 0.02)], X, r"folds\[0\].side = 'left'"),
        ([{"at": 0.3, "side": "up"}], X, r"folds\[0\] has or lacks radius"),
        ([(0.3, "up", -0.02)], X, "radius = -0.02 must be finite numbers"),
        ([(0.3, "up", "wide")], X, "radius = 'wide' must be"),
        ([(0.3, "up", 0.004)], X, "turns a sheet inside out: radius = 0.004 must exceed half"),
        ([(0.01, "up", 0.02)], X, "no panel between the lower end and the fold at 0.01"),
        ([(1.2, "up", 0.02)], X, "no panel between the fold at 1.2 and the upper end"),
        ([(0.3, "up", 0.06), (0.4, "down", 0.03)], X, "between the fold at 0.3 and the fold at"),
        ([(0.3, "up", 0.02)], (0.0, 0.0, 1.0), "along = .* normal to"),
        ([(0.3, "up", 0.02)], (1.0, 0.0), "along ="),
    ],
)
def test_folds_that_are_refused(folds, along, words):
    with pytest.raises(MeshError, match=words):
        pattern_folding(folds, along, pattern(10)[0])


def test_a_thick_body_is_no_pattern():
    with pytest.raises(MeshError, match=r"geometry.folds: no flat pattern, 0\.2 thick over 1"):
        pattern_folding([(0.3, "up", 0.02)], X, pattern(10)[0] * [1, 1, 20])


def test_panels_and_bends_make_up_the_length():
    folding = pattern_folding(FOLDS, X, pattern(10)[0])
    bends = [b - a for (_, a), (b, _) in pairwise(folding.panels)]
    np.testing.assert_allclose(bends, np.pi * 0.025, rtol=1e-12)
    assert folding.panels[0][0] == 0.0
    assert folding.panels[-1][1] == pytest.approx(1.0)
