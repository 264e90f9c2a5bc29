"""Energy and variations: finite differences, oracle in plain scikit-fem, identities."""

import numpy as np
import pytest
from skfem import Functional

from shells.energy.densities import NeoHookean, Skalak, StVenantKirchhoff
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

MATERIAL = Material(0.03, poisson_ratio=0.3)


def cone(degree, periodic=True):
    """A conical surface and a random configuration near it."""
    s = SplineSpace(np.linspace(0.0, 1.0, 4), degree)
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, 7), degree, periodic)
    surface = SplineSurface(s, t)
    angle, height = np.tile(t.greville, s.n), np.repeat(s.greville, t.n)
    radius = 1.0 + 0.3 * height
    X = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    noise = np.random.default_rng(0).standard_normal((2, *X.shape))
    return SurfaceBasis(surface, X), X, X + 0.1 * noise[0], noise[1].ravel()


def central(function, x, direction, step):
    plus, minus = function(x.ravel() + step * direction), function(x.ravel() - step * direction)
    return (plus - minus) / (2.0 * step)


@pytest.mark.parametrize("membrane", ["gauss", "reduced"])
@pytest.mark.parametrize("degree", [2, 3])
def test_variations_by_finite_differences(degree, membrane):
    basis, _, theta, d = cone(degree)
    shell = KirchhoffLove(basis, MATERIAL, membrane=membrane)
    gradient, tangent = shell.gradient_and_tangent(theta)
    errors = []
    for step in (1e-3, 1e-4):
        slope = central(lambda x: sum(shell.energy(x)), theta, d, step)
        curve = central(shell.gradient, theta, d, step)
        errors.append(
            [
                abs(slope / (gradient @ d) - 1.0),
                np.linalg.norm(curve - tangent @ d) / np.linalg.norm(tangent @ d),
            ]
        )
    # central differences: a hundredth of the error at a tenth of the step
    ratio = np.array(errors[0]) / np.array(errors[1])
    assert np.all(ratio > 90.0)
    assert np.all(np.array(errors[1]) < 2e-5)
    assert abs(tangent - tangent.T).max() < 1e-13


@pytest.mark.parametrize("degree", [2, 3])
def test_volume_variations_by_finite_differences(degree):
    basis, _, theta, d = cone(degree)
    volume = EnclosedVolume(basis)
    _, gradient, hessian = volume.derivatives(theta)
    assert central(volume.gradient, theta, d, 1e-2) == pytest.approx(hessian @ d, abs=1e-11)
    errors = [abs(central(volume.value, theta, d, h) - gradient @ d) for h in (1e-2, 1e-3)]
    assert errors[0] / errors[1] == pytest.approx(100.0, rel=0.05)  # Q is cubic


@pytest.mark.parametrize("degree", [2, 3])
def test_formulations_agree(degree):
    """[T thm 8]: the energy does not depend on the parametrization."""
    basis, _, theta, _ = cone(degree)
    free, classical = (
        KirchhoffLove(basis, MATERIAL, formulation=f) for f in ("parametrization-free", "classical")
    )
    assert free.energy(theta) == pytest.approx(classical.energy(theta), rel=1e-13)
    a, b = free.gradient_and_tangent(theta), classical.gradient_and_tangent(theta)
    assert np.abs(a[0] - b[0]).max() < 1e-13
    assert abs(a[1] - b[1]).max() < 1e-12


def test_energy_equals_a_readable_form():
    """The fused kernel against [T 2.8] written as a plain scikit-fem functional."""
    basis, X, theta, _ = cone(3)
    nu, D = MATERIAL.poisson_ratio, MATERIAL.flexural_rigidity

    def forms(field):
        t, h = field.grad, field.hess
        a = np.einsum("cieq,cjeq->ijeq", t, t)
        z = np.cross(t[:, 0], t[:, 1], axis=0)
        b = np.einsum("cijeq,ceq->ijeq", h, z / np.linalg.norm(z, axis=0))
        return a, b

    @Functional
    def energy(w):
        (a, b), (A, B) = forms(w["theta"]), forms(w["reference"])
        inverse = np.moveaxis(np.linalg.inv(np.moveaxis(A, (0, 1), (2, 3))), (2, 3), (0, 1))
        density = 0.0
        for strain, weight in ((0.5 * (a - A), 1.0), (b - B, D)):
            mixed = np.einsum("ijeq,jkeq->ikeq", inverse, strain)
            trace = np.einsum("iieq->eq", mixed)
            square = np.einsum("ijeq,jieq->eq", mixed, mixed)
            density = density + 0.5 * weight * (nu * trace**2 + (1.0 - nu) * square)
        return density

    oracle = energy.assemble(basis, theta=theta.ravel(), reference=X.ravel())
    assert sum(KirchhoffLove(basis, MATERIAL).energy(theta)) == pytest.approx(oracle, rel=1e-13)


def test_forms_keep_their_scikit_fem_meaning():
    basis, _, theta, _ = cone(2)
    shell = KirchhoffLove(basis, MATERIAL)
    x = theta.ravel()
    assert (
        abs(
            shell.stiffness.elemental(basis, x=x).tocsr() - shell.stiffness.assemble(basis, x=x)
        ).max()
        < 1e-14
    )
    assert np.allclose(
        shell.force.elemental(basis, x=x).toarray(), shell.force.assemble(basis, x=x)
    )
    with pytest.raises(ValueError, match="another basis"):
        shell.force.assemble(cone(2)[0], x=x)


def test_rigid_motion_stores_no_energy():
    basis, X, _, _ = cone(3)
    q, _ = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))
    moved = X @ (q * np.sign(np.linalg.det(q))).T + np.array([3.0, -1.0, 2.0])
    shell = KirchhoffLove(basis, MATERIAL)
    assert sum(shell.energy(moved)) < 1e-27
    assert np.abs(shell.gradient(moved)).max() < 1e-13


def test_hyperelastic_path_equals_the_fused_kernel():
    basis, _, theta, _ = cone(3)
    fused, hyperelastic = (
        KirchhoffLove(basis, MATERIAL),
        HyperelasticShell(basis, StVenantKirchhoff(MATERIAL)),
    )
    assert sum(hyperelastic.energy(theta)) == pytest.approx(sum(fused.energy(theta)), rel=1e-13)
    (a, A), (b, B) = (shell.gradient_and_tangent(theta) for shell in (fused, hyperelastic))
    assert np.abs(a - b).max() < 1e-12
    assert abs(A - B).max() < 1e-10


@pytest.mark.parametrize(("law", "nu"), [(NeoHookean, 0.5), (Skalak, 0.5), (Skalak, 0.9)])
def test_hyperelastic_laws_by_finite_differences_and_at_small_strain(law, nu):
    basis, X, theta, d = cone(2)
    material = Material(0.03, poisson_ratio=nu)
    rubber = HyperelasticShell(basis, law(material))
    theta = X + 0.3 * (theta - X)
    gradient, tangent = rubber.gradient_and_tangent(theta)
    slope = central(lambda x: rubber.energy(x)[0], theta, d, 1e-5)
    assert slope == pytest.approx(gradient @ d, rel=1e-6)
    curve = central(rubber.gradient, theta, d, 1e-5)
    assert np.linalg.norm(curve - tangent @ d) < 1e-6 * np.linalg.norm(tangent @ d)
    hooke = KirchhoffLove(basis, material)
    at_rest = rubber.gradient_and_tangent(X)[1] - hooke.gradient_and_tangent(X)[1]
    assert abs(at_rest).max() < 1e-12


def test_laws_refuse_a_poisson_ratio_that_they_cannot_have():
    with pytest.raises(ValueError, match=r"poisson_ratio = 0.5"):
        NeoHookean(MATERIAL)
    with pytest.raises(ValueError, match=r"above -0.5"):
        Skalak(Material(0.03, poisson_ratio=-0.6))


def test_wrong_input_is_refused():
    basis, X, _, _ = cone(2)
    with pytest.raises(ValueError, match="formulation"):
        KirchhoffLove(basis, MATERIAL, formulation="other")
    with pytest.raises(ValueError, match="expected coefficients"):
        basis.jets(X[:-1])
    with pytest.raises(ValueError, match="Poisson"):
        Material(1.0, poisson_ratio=1.5)
