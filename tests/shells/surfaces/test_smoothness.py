"""Hinges that nobody asked for, and knots that rounding cannot tell apart."""

import logging

import numpy as np
import pytest

import shells
from shells.energy.densities import StVenantKirchhoff
from shells.energy.hyperelastic import HyperelasticShell
from shells.surfaces.pillow import Pillow
from shells.surfaces.splines import RESOLVABLE

LENGTH = 10.0


def strip(breaks, degree=3, multiplicity=(), elements=None, across=1):
    s = shells.SplineSpace(breaks, degree, multiplicity=np.array(multiplicity, dtype=int))
    t = shells.SplineSpace(np.linspace(0.0, 1.0, across + 1), degree)
    surface = shells.SplineSurface(s, t, elements=elements)
    c = np.array([[x, y, 0.0] for x in s.greville for y in t.greville])[surface.kept]
    return surface, c


def cantilever_tip(surface, c):
    """Middle of the loaded end of Sze, Liu and Lo's cantilever under the full end shear."""
    shell = shells.KirchhoffLove(shells.SurfaceBasis(surface, c), shells.Material(1 / 1200, 1.2e5))
    supports = shells.supported(surface, shells.clamp(surface, "s", 0, (2,)))
    force = shells.line_load(surface, "s", 1, [0.0, 0.0, 4.0], c)
    structure = shells.ShellStructure(shell, supports)
    path = shells.load_path(structure, c, lambda f: f * force, [0.25, 0.5, 1.0])
    assert path.ok
    return path.state.coefficients[surface.ring(-1)].mean(axis=0) - [LENGTH, 0.5, 0.0]


@pytest.mark.parametrize("material", ["Hooke", "density"])
def test_a_hinge_in_a_clamped_strip_is_refused(material):
    """A triple knot at degree 3 deflected three times too far under a uniform load."""
    surface, c = strip([0.0, 3.0, 5.0, 10.0], 3, [1, 1, 3, 1])
    basis, hooke = shells.SurfaceBasis(surface, c), shells.Material(1e-2)

    def shell(material=hooke, **options):
        if material_name == "Hooke":
            return shells.KirchhoffLove(basis, material, **options)
        return HyperelasticShell(basis, StVenantKirchhoff(material), **options)

    material_name = material
    with pytest.raises(ValueError, match=r"knot s = 5, of multiplicity 3 at degree 3.*hinge.*2 or"):
        shell()
    shell(shells.Material(0.0))  # a membrane has no bending to lose
    shell(seams=True)
    # the double knot is C1 and right: q L^4 / (384 D) between two clamps, elements exact to p = 4
    smooth, c = strip(np.linspace(0.0, 10.0, 9), 3, [1, 1, 1, 1, 2, 1, 1, 1, 1])
    plate = shells.KirchhoffLove(shells.SurfaceBasis(smooth, c), hooke)
    E = shells.supported(smooth, shells.clamp(smooth, "s", 0), shells.clamp(smooth, "s", 1))
    load = np.zeros_like(c)
    ones = shells.SurfaceBasis(smooth, c, components=1)
    load[:, 2] = 1e-8 * np.bincount(
        ones.element_dofs.ravel(), np.einsum("aeq,eq->ae", ones.values, ones.dx).ravel()
    )
    moved = shells.ShellStructure(plate, E).static(c, load=load).state.coefficients[:, 2]
    middle = np.outer(smooth.s.evaluate(5.0)[0], smooth.t.evaluate(0.5)[0]).ravel() @ moved
    assert middle == pytest.approx(1e-8 * LENGTH**4 / 384 / 1e-2, rel=2e-3)


def test_every_c0_line_is_found_and_no_other():
    """Both directions, periodic ends, restrictions; a pillow is C1 by its wraps."""
    t = shells.SplineSpace(
        np.linspace(0.0, 1.0, 9), 2, periodic=True, multiplicity=np.array([2, 1, 1, 1, 1] + 4 * [1])
    )
    s = shells.SplineSpace([0.0, 1.0, 2.0], 2)
    tube = shells.SplineSurface(s, t)
    a = 2.0 * np.pi * np.tile(t.greville, s.n)
    c = np.stack([np.cos(a), np.sin(a), -np.repeat(s.greville, t.n)], axis=1)
    with pytest.raises(ValueError, match=r"knot t = 0, of multiplicity 2 at degree 2"):
        shells.KirchhoffLove(shells.SurfaceBasis(tube, c), shells.Material(1e-2))
    half = tube.restrict([e for e in range(16) if e % 8 < 4])  # its seam is an edge
    shells.KirchhoffLove(shells.SurfaceBasis(half, c[half.kept]), shells.Material(1e-2))
    bilinear, c = strip(np.linspace(0.0, 10.0, 9), 1)
    basis = shells.SurfaceBasis(bilinear, c)
    for seams in (False, True):
        with pytest.raises(ValueError, match="degree 1 have no curvature"):
            shells.KirchhoffLove(basis, shells.Material(1e-2), seams=seams)
    shells.KirchhoffLove(basis, shells.Material(0.0))
    pillow = Pillow(8, 4)
    c = np.random.default_rng(0).standard_normal((pillow.n_coefficients, 3))
    shells.KirchhoffLove(shells.SurfaceBasis(pillow, c), shells.Material(1e-2))
    with pytest.raises(ValueError, match=r"multiplicities must lie in 1\.\.2"):
        shells.SplineSpace(np.arange(5.0), 2, periodic=True, multiplicity=np.array([3, 1, 1, 1, 3]))


def test_knots_that_rounding_cannot_tell_apart():
    """At 1e-9 beside 5 the tip was (-2.65, .06, 6.24); merged it is that of a double knot."""
    breaks = np.linspace(0.0, LENGTH, 17)
    right = cantilever_tip(*strip(breaks, 3, [1] * 8 + [2] + [1] * 8))
    assert right == pytest.approx([-3.2894, 0.0, 6.6997], abs=1e-4)
    with pytest.raises(ValueError, match=r"breaks\[8\] = 5 and breaks\[9\] = 5.000000001 are"):
        strip(np.sort(np.r_[breaks, 5.0 + 1e-9]))
    # just above the limit the strip is right, rounding and all
    assert cantilever_tip(*strip(np.sort(np.r_[breaks, 5.0 + 1.01 * RESOLVABLE * LENGTH]))) == (
        pytest.approx(right, abs=1e-6)
    )


def test_near_knots_of_a_knot_vector_become_one(caplog):
    knots = [0.0] * 4 + [0.3, 0.1 + 0.2, 0.7] + [1.0] * 4
    with caplog.at_level(logging.WARNING):
        space = shells.SplineSpace.from_knots(np.array(knots), 3)
    assert "knots[4] = 0.3 and knots[5] = 0.3" in caplog.text
    assert space.breaks == pytest.approx([0.0, 0.3, 0.7, 1.0])
    assert list(space.multiplicity) == [1, 2, 1, 1]
    assert space.n == len(knots) - 4
    four = [0.5 + k * 1e-12 for k in range(4)]
    with pytest.raises(ValueError, match=r"multiplicities must lie in 1\.\.3"):
        shells.SplineSpace.from_knots([0.0] * 4 + four + [1.0] * 4, 3)
    with pytest.raises(ValueError, match="4 fold ends"):
        shells.SplineSpace.from_knots([0.0] * 4 + [1e-12] + [1.0] * 4, 3)


def test_splines_far_from_zero():
    """Extraction in differences of breaks: 1e-10 off a million lengths away before."""
    near = shells.SplineSpace(np.linspace(0.0, 1.0, 9), 3)
    far = shells.SplineSpace(2.0**20 + np.linspace(0.0, 1.0, 9), 3)
    assert np.abs(far.extraction - near.extraction).max() < 1e-14
