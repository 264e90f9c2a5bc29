"""Restrictions that cut a surface into pieces: they hang together nowhere, and move alone."""

import numpy as np
import pytest

import shells
from shells.surfaces.pillow import Pillow


def cut_strip(degree, without, across=1, length=10.0):
    """A strip of 16 columns of elements without some, its coefficients and its structure parts."""
    s = shells.SplineSpace(np.linspace(0.0, length, 17), degree)
    t = shells.SplineSpace(np.linspace(0.0, 1.0, across + 1), degree)
    whole = shells.SplineSurface(s, t)
    c = np.array([[x, y, 0.0] for x in s.greville for y in t.greville])
    part = whole.restrict([e for e in range(16 * across) if e not in without])
    shell = shells.KirchhoffLove(
        shells.SurfaceBasis(part, c[part.kept]), shells.Material(1e-2, poisson_ratio=0.3)
    )
    return part, c[part.kept], shell


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("gap", [1, 3, 5])
def test_a_piece_cut_off_is_a_mechanism(degree, gap):
    """Functions that span the cut held the free half: ``ok`` for gaps below p - 1 columns."""
    strip, c, shell = cut_strip(degree, set(range(8, 8 + gap)))
    structure = shells.ShellStructure(shell, shells.supported(strip, shells.clamp(strip, "s", 0)))
    load = shells.line_load(strip, "s", 1, [0.0, 0.0, 1e-6], c)
    found = (
        rf"6 rigid motion.*translation along x.*piece of {8 - gap} element.*from number {8 + gap}"
    )
    with pytest.raises(ValueError, match=found + " to 15.*2 pieces"):
        structure.static(c, load=load)


def test_pieces_that_touch_in_a_corner_are_two():
    strip, c, shell = cut_strip(3, {17} | set(range(18, 32, 2)) | set(range(20, 32)), across=2)
    assert len(np.unique(strip.pieces)) == 2
    structure = shells.ShellStructure(shell, shells.supported(strip, shells.clamp(strip, "s", 0)))
    with pytest.raises(ValueError, match=r"unsupported piece of 1 element\(s\) from number 19"):
        structure.static(c, load=np.ones_like(c) * 1e-9)


def test_supported_pieces_bend_alone():
    """Both ends clamped, one column missing: each half is the cantilever of its own length."""
    strip, c, shell = cut_strip(3, {8})
    E = shells.supported(strip, shells.clamp(strip, "s", 0), shells.clamp(strip, "s", 1))
    load = shells.point_load(strip, 5.0 - 1e-9, 0.5, [0.0, 0.0, 1e-7])
    load += shells.point_load(strip, 5.625, 0.5, [0.0, 0.0, -1e-7])
    assert load.sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-20)
    end = shells.ShellStructure(shell, E).static(c, load=load)
    assert end.ok
    for elements, place, sign in ((range(8), 5.0, 1.0), (range(9, 16), 5.625, -1.0)):
        half, x, alone = cut_strip(3, set(range(16)) - set(elements))
        clamp = shells.clamp(half, "s", 0 if sign > 0 else 1)
        force = shells.point_load(
            half, place - (1e-9 if sign > 0 else 0.0), 0.5, [0, 0, 1e-7 * sign]
        )
        own = shells.ShellStructure(alone, shells.supported(half, clamp)).static(x, load=force)
        piece = np.isin(strip.kept, half.kept) & (
            strip.coefficient_pieces == strip.pieces[0 if sign > 0 else -1]
        )
        assert end.state.coefficients[piece] == pytest.approx(own.state.coefficients, abs=1e-12)
        assert sign * own.state.coefficients[:, 2].max() >= 0.0


def test_pieces_of_a_pillow():
    """Its zipped ends hold together what the grid of elements has apart."""
    whole = Pillow(8, 6)
    assert not whole.pieces.any()
    rows = np.arange(48).reshape(8, 6)
    ends = whole.restrict(rows[:, [0, 5]].ravel())
    assert len(np.unique(ends.pieces)) == 2  # each end is one band, folded on itself
    side = whole.restrict(rows[[1, 6], :2].ravel())  # two strips zipped to each other
    assert not side.pieces.any()
    apart = whole.restrict(rows[[1, 2, 4], 1:5].ravel())
    assert len(np.unique(apart.pieces)) == 2
    assert apart.n_coefficients == 6 * 4 + 6 * 3
    assert apart.reduction.shape[0] == apart.n_coefficients


@pytest.mark.parametrize(("degree", "error"), [(2, 0.02), (3, 0.08), (4, 0.06)])
def test_a_slit_has_two_lips(degree, error):
    """Functions over a slit one element wide tied its lips: 16% too stiff at degree 3."""

    def compliance(n, slit):
        s = shells.SplineSpace(np.linspace(0.0, 4.0, n + 1), degree)
        t = shells.SplineSpace(np.linspace(0.0, 1.0, n // 4 + 1), degree)
        whole, x = shells.SplineSurface(s, t), (s.greville, t.greville)
        i, j = np.divmod(np.arange(n * n // 4), n // 4)
        cut = (i // (n // 16) == 8) & (j < 3 * n // 16)  # three quarters of the width
        plate = whole.restrict(np.flatnonzero(~cut)) if slit else whole
        c = np.array([[a, b, 0.0] for a in x[0] for b in x[1]])[plate.kept]
        shell = shells.KirchhoffLove(shells.SurfaceBasis(plate, c), shells.Material(1e-2))
        E = shells.supported(plate, shells.clamp(plate, "s", 0, (2,)))
        load = shells.line_load(plate, "s", 1, [0.0, 0.0, 1e-7], c)
        end = shells.ShellStructure(shell, E).static(c, load=load)
        assert end.ok
        assert len(np.unique(plate.pieces)) == 1
        return ((end.state.coefficients - c) * load).sum()

    whole, slit = compliance(16, False), compliance(16, True)
    assert slit / whole == pytest.approx(0.2711 / 0.21333, rel=error)
