"""Where there is no equilibrium near: limit points, membranes that nothing stretches yet."""

import numpy as np
import pytest

import shells
from cases.geometry.revolution import sphere
from shells.conditions.supports import extraction
from shells.equilibrium.newton import NewtonOutcome


def balloon():
    """A neo-Hookean sphere of radius 1 and the pressure at its limit point."""
    surface, c = sphere(3, 4, 8)
    basis = shells.SurfaceBasis(surface, c)
    rubber = shells.NeoHookean(shells.Material(1e-8, poisson_ratio=0.5))
    shell = shells.HyperelasticShell(basis, rubber)
    E = extraction(surface.reduction)
    stretch = np.linspace(1.0, 2.0, 4001)
    limit = (0.5 * (1.0 / stretch - 1.0 / stretch**7)).max()
    return shells.ShellStructure(shell, E, shells.EnclosedVolume(basis)), c, limit


def test_pressure_above_the_limit_point_of_a_balloon():
    """300 iterations to a stretch of 26, then ``LIMIT``."""
    structure, c, limit = balloon()
    end = shells.minimise(structure, c, 1.25 * limit)
    assert end.outcome is NewtonOutcome.NO_EQUILIBRIUM
    assert end.iterations < 100
    # found to 1/128 below; the mesh carries 0.3% more or less
    assert 0.8 - 1.5 / 128 < end.factor < 0.8 + 0.003
    assert f"no equilibrium beyond {end.factor:.4g} of the loads" in end.failure
    # what is returned is the equilibrium at that share
    state, pressure = end.state.coefficients.ravel(), end.factor * 1.25 * limit
    assert end.state.pressure == pytest.approx(pressure)
    force = pressure * structure.enclosure.gradient(state)
    left = structure.E.T @ (structure.shell.gradient(state) - force)
    assert np.linalg.norm(left) < 1e-7 * np.linalg.norm(structure.E.T @ force)
    below = shells.minimise(structure, c, 0.98 * limit)
    assert below.ok
    assert below.factor == 1.0
    assert below.failure == ""


def sheet(rigidity):
    """A flat unstressed unit square on hinged edges, and a shallow bulge over them."""
    s = shells.SplineSpace(np.linspace(0.0, 1.0, 7), 3)
    square = shells.SplineSurface(s, s)
    c = np.array([[x, y, 0.0] for x in s.greville for y in s.greville])
    basis = shells.SurfaceBasis(square, c)
    shell = shells.KirchhoffLove(basis, shells.Material(rigidity, poisson_ratio=0.3))
    edges = [shells.hinge(square, d, end) for d in "st" for end in (0, 1)]
    E = shells.supported(square, *edges)
    x, y = c[:, 0], c[:, 1]
    bulge = c + np.outer(x * (1.0 - x) * y * (1.0 - y), [0.0, 0.0, 0.5])
    return shells.ShellStructure(shell, E, shells.EnclosedVolume(basis)), c, bulge


@pytest.mark.parametrize("rigidity", [0.0, 1e-13])
def test_a_membrane_without_bending(rigidity):
    """375 iterations, a residual of 5e20, and the advice to descend a load without potential."""
    structure, flat, bulge = sheet(rigidity)

    def load(fraction):
        return shells.follower_pressure(structure.shell.basis, 1e-2 * fraction)

    path = shells.load_path(structure, flat, load, [0.5, 1.0], floor=0.1)
    assert not path.ok
    assert "start from a configuration that its edges stretch" in path.failure
    assert "minimise" not in path.failure
    stretched = shells.load_path(structure, bulge, load, [1.0])
    assert stretched.ok
    assert stretched.newton_iterations < 25
    # its edges are held, so that the pressure has a potential here
    lowest = shells.minimise(structure, flat, 1e-2)
    assert stretched.state.coefficients == pytest.approx(lowest.state.coefficients, abs=1e-7)
    dead = shells.load_path(structure, flat, lambda f: 1e-3 * f * np.ones_like(flat), [1.0])
    assert not dead.ok
    assert "or use shells.minimise" in dead.failure


def test_no_advice_to_descend_a_load_without_potential():
    structure, flat, _ = sheet(1e-2)
    square = structure.shell.basis.surface
    hinged = shells.ShellStructure(
        structure.shell, shells.supported(square, shells.hinge(square, "s", 0))
    )
    with pytest.raises(ValueError, match="rotation about y; support them") as refused:
        hinged.static(flat, load=shells.follower_pressure(structure.shell.basis, 1e-2))
    assert "minimise" not in str(refused.value)


def test_a_huge_load_is_no_mechanism():
    """Its linear answer is a million lengths away, but solves the linear system."""
    structure, flat, _ = sheet(1e-2)
    down = structure.static(flat, load=1e12 * np.ones_like(flat))
    assert down.outcome is NewtonOutcome.DIVERGED
    limp, flat, _ = sheet(0.0)
    assert limp.static(flat, load=np.ones_like(flat)).outcome is NewtonOutcome.SINGULAR


def test_nothing_balances_a_free_resultant():
    """300 iterations, then ``LIMIT``: the plate flew away by a tenth of its length in each."""
    structure, flat, _ = sheet(1e-2)
    square = structure.shell.basis.surface
    free = shells.ShellStructure(structure.shell, shells.supported(square))
    down = np.zeros_like(flat)
    down[:, 2] = -1e-6
    with pytest.raises(
        ValueError, match=r"resultant of -8\.1e-05 along a free translation along z"
    ):
        shells.minimise(free, flat, load=down)
    down[square.ring(4)] *= 0.0
    down[square.ring(4), 2] = -down[:, 2].sum() / square.t.n
    assert shells.minimise(free, flat, load=down).ok
    hinged = shells.supported(square, shells.hinge(square, "s", 0))
    assert shells.minimise(shells.ShellStructure(structure.shell, hinged), flat, load=down).ok
