"""Parts of bags between symmetry planes: the closing surface lies in the planes."""

import numpy as np
import pytest

import shells
from shells.conditions.supports import extraction


def cushion(part, shift=0.0):
    """The upper sheet of a square cushion of side 2, sewn to its mirror image at z = 0.

    ``part`` is the "whole" sheet, or the "half" or "quarter" in x > 0 (and y > 0).
    """
    half, whole = (shells.SplineSpace(np.linspace(a, 1.0, n), 3) for a, n in ((0.0, 5), (-1.0, 9)))
    s, t = {"whole": (whole, whole), "half": (half, whole), "quarter": (half, half)}[part]
    sheet = shells.SplineSurface(s, t)
    c = np.array([[x + shift, y, 0.0] for x in s.greville for y in t.greville])
    planes = [shells.symmetry(sheet, "s", 0, 0)] if part != "whole" else []
    planes += [shells.symmetry(sheet, "t", 0, 1)] if part == "quarter" else []
    rims = [(d, end) for d in "st" for end in (0, 1)]
    cut = {"whole": 0, "half": 1, "quarter": 2}[part]
    rims = [r for r in rims if r not in [("s", 0), ("t", 0)][:cut]]
    # the seam turns freely and moves in its plane
    E = shells.supported(sheet, *planes, *(shells.hinge(sheet, d, e, (2,)) for d, e in rims))
    shell = shells.KirchhoffLove(
        shells.SurfaceBasis(sheet, c), shells.Material(1e-3, poisson_ratio=0.3)
    )
    return shell, E, c


def test_a_quarter_of_a_cushion_is_a_quarter_of_the_whole():
    """It was refused, with the advice to use a form that takes tubes only."""
    volumes, middles = [], []
    for part in ("whole", "quarter"):
        shell, E, c = cushion(part)
        structure = shells.ShellStructure(shell, E, shells.EnclosedVolume(shell.basis))
        end = shells.minimise(structure, c, 0.02)
        assert end.ok
        volumes.append(structure.volume(end.state.coefficients))
        s, t = shell.basis.surface.s, shell.basis.surface.t
        at = np.outer(s.evaluate(0.0)[0], t.evaluate(0.0)[0]).ravel()
        middles.append(at @ end.state.coefficients[:, 2])
    # the quarter's odd components may bend at the planes, the whole's are C2
    assert 4.0 * volumes[1] == pytest.approx(volumes[0], rel=1e-5)
    assert middles[1] == pytest.approx(middles[0], rel=5e-5)
    # the quarter needs no pins: a prescribed volume finds the pressure again
    grown = structure.static(end.state.coefficients, 1.1 * volumes[1], pressure=0.02)
    assert grown.ok
    back = structure.static(grown.state.coefficients, volumes[1], pressure=grown.state.pressure)
    assert back.state.pressure == pytest.approx(0.02, rel=1e-6)


def test_the_apex_lies_in_all_planes():
    shell, E, c = cushion("half", shift=3.0)
    with pytest.raises(ValueError, match=r"apex=\[3.0, 0.0, 0.0\]"):
        shells.ShellStructure(shell, E, shells.EnclosedVolume(shell.basis))
    moved = shells.ShellStructure(
        shell, E, shells.EnclosedVolume(shell.basis, apex=[3.0, 0.0, 0.0])
    )
    there = shells.minimise(moved, c, 0.02)
    shell, E, c = cushion("half")
    here = shells.minimise(
        shells.ShellStructure(shell, E, shells.EnclosedVolume(shell.basis)), c, 0.02
    )
    assert there.ok
    assert there.state.coefficients - [3.0, 0.0, 0.0] == pytest.approx(
        here.state.coefficients, abs=1e-9
    )
    # between two parallel planes no cone closes both edges
    sheet = shell.basis.surface
    edges = [shells.symmetry(sheet, "s", end, 0) for end in (0, 1)]
    edges += [shells.hinge(sheet, "t", end, (2,)) for end in (0, 1)]
    slab = shells.supported(sheet, *edges)
    with pytest.raises(ValueError, match=r"moves in the plane x = 1, another in the parallel"):
        shells.ShellStructure(shell, slab, shells.EnclosedVolume(shell.basis))


def test_cut_rims_are_edges_too():
    """The free rim of a restriction, which nothing closes, was loaded without a word."""
    from cases.geometry.revolution import sphere

    surface, c = sphere(3, 6, 8)
    cup = surface.restrict(np.arange(24))
    basis = shells.SurfaceBasis(cup, c[cup.kept])
    shell = shells.KirchhoffLove(basis, shells.Material(1e-3))
    with pytest.raises(ValueError, match="edge at the rim of the restriction is open and moves"):
        shells.ShellStructure(shell, extraction(cup.reduction), shells.EnclosedVolume(basis))
    # held in its plane, the equator, it closes the half ball
    rim = cup.open_edges["at the rim of the restriction"]
    at_rim = np.flatnonzero(abs(rim).sum(axis=0).A1 if hasattr(rim, "A1") else abs(rim).sum(axis=0))
    fixed = np.unique(3 * at_rim + 2)
    held = shells.ShellStructure(
        shell, extraction(cup.reduction, fixed), shells.EnclosedVolume(basis)
    )
    assert held.volume(c[cup.kept]) == pytest.approx(2.0 * np.pi / 3.0, rel=2e-3)
