"""The repulsive traction of two sheets diverges as its closed form says; Newton's third law."""

import numpy as np
import pytest

from coupling.repulsion import Repulsion


def traction(gap, exponent, n=41):
    """Of the middle of one sheet, by a rule of n x n points on the other."""
    half = 4.2 * gap  # the cut ends the kernel at 3.9 gaps
    g = (np.arange(n) + 0.5) / n * 2.0 * half - half
    x, y = (v.ravel() for v in np.meshgrid(g, g, indexing="ij"))
    sheet = np.stack([x, y, np.full_like(x, gap)], axis=1)
    points = np.concatenate([np.zeros((1, 3)), sheet])
    normals = np.concatenate([[[0.0, 0.0, -1.0]], np.tile([0.0, 0.0, 1.0], (len(sheet), 1))])
    # the sheets turn their outsides to each other: exterior contact
    weights = np.append(1.0, np.full(len(sheet), (2.0 * half / n) ** 2))
    middle = Repulsion(1.0, 1.0, exponent)
    return middle.forces(points, -normals, weights)


@pytest.mark.parametrize("gap", [1e-2, 1e-3])
def test_closed_form_of_two_sheets(gap):
    force = traction(gap, 5.0)
    k, c = 0.25, 0.5
    exact = 2.0 * np.pi / gap * (2.0 / 3.0 * (1.0 - k**3) - 0.5 * c * (1.0 - k**2))
    assert -force[0, 2] == pytest.approx(exact, rel=3.0 * (4.0 * gap) ** 2 + 3e-3)
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * exact


def test_literal_exponent_stays_bounded():
    assert traction(1e-3, 4.0)[0, 2] == pytest.approx(traction(1e-2, 4.0)[0, 2], rel=0.02)


def test_same_sheet_feels_nothing():
    """A sphere of radius 2 l: neighbours see normals differing by less than the cut."""
    rng = np.random.default_rng(0)
    normals = rng.standard_normal((4000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert not Repulsion(1.0, 0.5).forces(normals, normals, np.ones(4000) / 4000).any()
