"""Shells against published and exact figures."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve
from skfem import BilinearForm, LinearForm, condense, solve
from skfem.helpers import dd, ddot

from shells.dynamics import ShellState, ShellStructure
from shells.kirchhoff_love import KirchhoffLove
from shells.material import Material
from shells.splines import SplineSpace
from shells.support import extraction, vector_dofs
from shells.surface import SplineSurface, ring_scale
from shells.surface_basis import SurfaceBasis
from shells.volume import EnclosedVolume


def stack(*components):
    return np.stack(np.broadcast_arrays(*components), axis=-1)


@pytest.mark.parametrize(("degree", "rate"), [(2, 1.0), (3, 2.0)])
def test_biharmonic_on_an_unmodified_form(degree, rate):
    """Rate p - 1 in the second derivatives of a simply supported plate."""
    errors = []
    for n in (8, 16):
        space = SplineSpace(np.linspace(0.0, 1.0, n + 1), degree)

        def flat(s, t):
            zero, one = 0.0 * s, 1.0 + 0.0 * s
            return (
                stack(s, t, zero),
                (stack(one, zero, zero), stack(zero, one, zero)),
                [stack(zero, zero, zero)] * 3,
            )

        basis = SurfaceBasis(SplineSurface(space, space), flat, components=1)
        A = BilinearForm(lambda u, v, w: ddot(dd(u), dd(v))).assemble(basis)
        f = LinearForm(
            lambda v, w: 4 * np.pi**4 * np.sin(np.pi * w.x[0]) * np.sin(np.pi * w.x[1]) * v
        ).assemble(basis)
        fixed = np.unique(np.concatenate([basis.boundary(d, e) for d in "st" for e in (0, 1)]))
        u = basis.interpolate(solve(*condense(A, f, D=fixed)))
        s, t = np.asarray(basis.global_coordinates())
        exact = -(np.pi**2) * np.sin(np.pi * s) * np.sin(np.pi * t)
        errors.append(np.sqrt(((u.hess[0, 0] - exact) ** 2 * basis.dx).sum()))
    assert np.log2(errors[0] / errors[1]) > rate - 0.1


def test_scordelis_lo():
    """-0.3002312 at 32^2, p = 2, under 5/6e-6 (the 5/3e-6 of [T 6.3.1] counts a half twice)."""
    n, R, L, phi = 32, 25.0, 50.0, np.deg2rad(40.0)
    s, t = SplineSpace(np.linspace(-1, 1, n + 1), 2), SplineSpace(np.linspace(0, L, n + 1), 2)
    surface = SplineSurface(s, t)

    def roof(s, t):
        a, zero = phi * s, 0.0 * s
        sin, cos = R * np.sin(a), R * np.cos(a)
        return (
            stack(sin, t, cos),
            (phi * stack(cos, zero, -sin), stack(zero, 1.0, zero)),
            (phi**2 * stack(-sin, zero, -cos), stack(zero, zero, zero), stack(zero, zero, zero)),
        )

    basis = SurfaceBasis(surface, roof)
    shell = KirchhoffLove(basis, Material(1.0 / 192.0), exact_reference=True)
    ends = np.concatenate([surface.column(0), surface.column(-1)])
    pin = vector_dofs(surface.column(0)[:1], (1,))
    E = extraction(surface.reduction, np.unique(np.r_[vector_dofs(ends, (0, 2)), pin]))
    load = LinearForm(lambda v, w: -5.0 / 6.0 * 1e-6 * v[2]).assemble(basis)
    _, K = shell.gradient_and_tangent(np.zeros(basis.N))
    u = (E @ spsolve((E.T @ K @ E).tocsc(), E.T @ load)).reshape(-1, 3)
    at_A = np.outer(s.evaluate(1.0)[0], t.evaluate(L / 2)[0]).ravel()
    assert (at_A @ u)[2] == pytest.approx(-0.3002312, abs=5e-8)


def ring(degree, n):
    """A plane-strain ring of unit radius and width: one column of rings, tied together."""
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, n + 1), degree, periodic=True)
    s = SplineSpace(np.linspace(0.0, 1.0, 3), degree)
    surface = SplineSurface(s, t)
    a = np.tile(t.greville, s.n)
    c = np.stack([np.cos(a), np.sin(a), -np.repeat(s.greville, t.n)], axis=1)
    c[:, :2] /= ring_scale(t)
    tie = coo_matrix((np.ones(a.size), (np.arange(a.size), np.tile(np.arange(t.n), s.n)))).tocsr()
    basis = SurfaceBasis(surface, c)
    # rigid motions are not excited by a symmetric start; inertia (dt = 1e4) removes their null
    # space and moves the pressure by 1e-9
    fixed = vector_dofs(np.arange(a.size), (2,))
    shell = KirchhoffLove(basis, Material(1e-3))
    return ShellStructure(shell, extraction(tie, fixed), EnclosedVolume(basis)), c


@pytest.mark.parametrize("degree", [2, 3])
def test_pressurised_ring(degree):
    """Ring stretched to l: p = [(l^2-1) l/2 + eps (l-1)] / l exactly, error O(h^4) or better."""
    stretch, eps, errors = 1.2, 1e-3, []
    exact = ((stretch**2 - 1) * stretch / 2 + eps * (stretch - 1)) / stretch
    for n in (8, 16):
        structure, c = ring(degree, n)
        # flat ends at constant height: Q is two thirds of the enclosed volume, so p is too
        state = ShellState(0.0, c, np.zeros_like(c))
        target = 2.0 / 3.0 * np.pi * stretch**2
        step = structure.step(state, None, 1e4, target)
        assert step.ok
        errors.append(abs(2.0 / 3.0 * step.state.pressure / exact - 1.0))
    assert errors[1] < {2: 3e-4, 3: 2e-5}[degree]
    assert np.log2(errors[0] / errors[1]) > 3.5


def test_volume_of_a_closed_form():
    """A cylinder's short and full volume forms agree with pi R^2 L on the fitted circle."""
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, 25), 3, periodic=True)
    s = SplineSpace(np.linspace(0.0, 1.0, 3), 3)
    surface = SplineSurface(s, t)
    a = np.tile(t.greville, s.n)
    c = np.stack([np.cos(a), np.sin(a), -np.repeat(s.greville, t.n)], axis=1)
    c[:, :2] /= ring_scale(t)
    basis = SurfaceBasis(surface, c)
    structure = ShellStructure(
        KirchhoffLove(basis, Material(1.0)), extraction(surface.reduction), EnclosedVolume(basis)
    )
    # the open ends add nothing: z runs from 0 to -1 and the lower lid holds pi / 3
    assert structure.volume(c) == pytest.approx(2.0 * np.pi / 3.0, rel=2e-5)
    assert structure.area(c) == pytest.approx(2.0 * np.pi, rel=2e-5)
