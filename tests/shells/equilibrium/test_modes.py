"""Vibration and buckling against closed forms, dense against sparse."""

import numpy as np
import pytest

import shells
from shells.equilibrium import modes

D, LENGTH = 1e-6, 2.0


def strip(n=8, supports=("clamp",), poisson=0.0, width=0.2):
    s = shells.SplineSpace(np.linspace(0.0, LENGTH, n + 1), 3)
    t = shells.SplineSpace([0.0, width], 3)
    surface = shells.SplineSurface(s, t)
    c = np.array([[x, y, 0.0] for x in s.greville for y in t.greville])
    shell = shells.KirchhoffLove(
        shells.SurfaceBasis(surface, c), shells.Material(D, poisson_ratio=poisson)
    )
    E = shells.supported(surface, shells.clamp(surface, "s", 0, (2,)))
    return surface, c, shells.ShellStructure(shell, E)


@pytest.mark.parametrize("dense", [True, False])
def test_euler_buckling_of_a_cantilever(dense, monkeypatch):
    """Critical loads ``D (k pi / 2 L)^2``, k = 1, 3, 5, whatever the size of the load given."""
    monkeypatch.setattr(modes, "DENSE", 10**6 if dense else 0)
    surface, c, structure = strip(16)
    exact = D * (np.array([1.0, 3.0, 5.0]) * np.pi / (2.0 * LENGTH)) ** 2
    for size in (1.0, 1e-7):
        load = shells.line_load(surface, "s", 1, [-size, 0.0, 0.0], c)
        found = shells.lowest_modes(structure, c, 3, load=load)
        assert size * found.values == pytest.approx(exact, rel=2e-4)
    # the first mode is 1 - cos
    x, z = c[:, 0], found.shapes[0, :, 2]
    basis = structure.shell.basis.surface.s.evaluate(np.linspace(0.0, LENGTH, 9))
    line = basis @ z.reshape(surface.s.n, -1)[:, 0]
    shape = 1.0 - np.cos(0.5 * np.pi * np.linspace(0.0, 1.0, 9))
    assert np.abs(line / line[-1] - shape).max() < 1e-4
    assert x.shape == z.shape
    pulled = shells.line_load(surface, "s", 1, [1.0, 0.0, 0.0], c)
    none = shells.lowest_modes(structure, c, 3, load=pulled)
    assert (none.values > 1e3 * exact[0]).all()
    assert none.shapes.shape == (none.values.size, *c.shape)


@pytest.mark.parametrize("dense", [True, False])
def test_vibration_of_a_hinged_plate(dense, monkeypatch):
    """``w^2 = D (pi^2 (i^2 + j^2))^2`` of the unit square, and rigid motions of a free one."""
    monkeypatch.setattr(modes, "DENSE", 10**6 if dense else 0)
    s = shells.SplineSpace(np.linspace(0.0, 1.0, 9), 3)
    square = shells.SplineSurface(s, s)
    c = np.array([[x, y, 0.0] for x in s.greville for y in s.greville])
    shell = shells.KirchhoffLove(shells.SurfaceBasis(square, c), shells.Material(D))
    edges = [shells.hinge(square, d, end) for d in "st" for end in (0, 1)]
    structure = shells.ShellStructure(shell, shells.supported(square, *edges))
    found = shells.lowest_modes(structure, c, 4)
    exact = D * np.pi**4 * np.array([2.0, 5.0, 5.0, 8.0]) ** 2
    assert found.values == pytest.approx(exact, rel=1e-3)
    assert np.abs(found.shapes).reshape(4, -1).max(axis=1) == pytest.approx(np.ones(4))
    corner = shells.supported(square, shells.pin(square, 0, (2,)))
    free = shells.lowest_modes(shells.ShellStructure(shell, corner), c, 6)
    assert np.abs(free.values[:5]).max() < 1e-10
    assert free.values[5] > 1e-6


def test_unstable_states_have_negative_modes(monkeypatch):
    """A strip compressed beyond its critical strain, dense and sparse alike."""
    surface, c, structure = strip()
    pressed = c * [1.0 - 1e-3, 1.0, 1.0]
    values = []
    for size in (10**6, 0):
        monkeypatch.setattr(modes, "DENSE", size)
        values.append(shells.lowest_modes(structure, pressed, 4).values)
    assert values[0][0] < 0.0
    assert values[1] == pytest.approx(values[0], rel=1e-6)
    with pytest.raises(ValueError, match="unstable without the load"):
        shells.lowest_modes(
            structure, pressed, load=shells.line_load(surface, "s", 1, [-1.0, 0.0, 0.0], c)
        )


def test_what_has_no_modes_is_refused():
    surface, c, structure = strip()
    with pytest.raises(ValueError, match="acts on supported coefficients only"):
        shells.lowest_modes(structure, c, load=shells.line_load(surface, "s", 0, [0, 0, 1.0], c))
    hinged = shells.supported(surface, shells.hinge(surface, "s", 0))
    with pytest.raises(ValueError, match="rotation about y"):
        shells.lowest_modes(
            shells.ShellStructure(structure.shell, hinged),
            c,
            load=shells.line_load(surface, "s", 1, [-1.0, 0.0, 0.0], c),
        )
    with pytest.raises(ValueError, match="no potential"):
        shells.lowest_modes(structure, c, load=shells.follower_pressure(structure.shell.basis, 1.0))
