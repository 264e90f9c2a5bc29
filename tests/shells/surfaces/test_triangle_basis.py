"""Triangles as a scikit-fem basis: plain forms, projection, mass, volume, jets."""

import numpy as np
import pytest
from skfem import BilinearForm, Functional, LinearForm

from cases.benchmarks.meshes.raw import interpolated, rectangle, sphere
from cases.benchmarks.shells.speed import plain_arguments, plain_tangent
from shells.conditions.rigid_motions import coefficients_of, mechanism
from shells.conditions.supports import extraction
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.surfaces.triangles.triangle_basis import TriangleBasis
from shells.surfaces.triangles.triangle_surface import TriangleSurface


def flat(degree, n=3, components=3):
    points, triangles = rectangle(n)
    surface, c = interpolated(
        np.column_stack([points, np.zeros(len(points))]), triangles, degree, lambda x: x
    )
    return TriangleBasis(surface, c, components=components), c


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_plain_forms(degree):
    basis, c = flat(degree, components=1)
    assert Functional(lambda w: 1.0).assemble(basis) == pytest.approx(1.0)
    x, y = c[:, 0], c[:, 1]  # linear functions reproduce themselves
    mass = BilinearForm(lambda u, v, w: u * v).assemble(basis)
    assert x @ mass @ y == pytest.approx(0.25)
    load = LinearForm(lambda v, w: w.x[0] * v).assemble(basis)
    assert load == pytest.approx(mass @ x, abs=1e-15)
    assert basis.project(lambda p: 2.0 * p[0] - p[1]) == pytest.approx(2.0 * x - y, abs=1e-12)


def test_second_derivatives():
    basis, _ = flat(3, components=1)
    cubic = interpolated_values(basis.surface, lambda x: x[..., 0] ** 3)
    field = basis.interpolate(cubic)
    t = basis.reference.grad[..., 0]
    x = basis.reference.value[..., 0]
    exact = 6.0 * x * t[0] * t[1]  # affine triangles: f_xx x_xi x_eta
    assert np.asarray(field.hess)[0, 1] == pytest.approx(exact, abs=1e-12)


def test_fused_kernel_against_a_plain_form():
    """The tangent of the energy as a readable scikit-fem form: nothing of it knows triangles."""
    basis, c, _ = raw_ball(3, 16)
    material = Material(0.03, poisson_ratio=0.3)
    shell = KirchhoffLove(basis, material, formulation="classical", seams=True)
    theta = c + 0.03 * np.random.default_rng(0).standard_normal(c.shape)
    plain = plain_tangent.assemble(basis, **plain_arguments(shell, theta))
    fused = shell.gradient_and_tangent(theta)[1]
    assert abs(plain - fused).max() < 1e-13 * abs(plain).max()
    assert abs(shell.stiffness.assemble(basis, x=theta) - fused).max() == 0.0


def interpolated_values(surface, f):
    points, triangles = rectangle(3)
    three = np.column_stack([points, np.zeros(len(points))])
    return interpolated(three, triangles, surface.degree, lambda x: f(x)[..., None])[1][:, 0]


def raw_ball(degree, n):
    surface, c = interpolated(
        *sphere(n), degree, lambda x: x / np.linalg.norm(x, axis=-1, keepdims=True)
    )
    basis = TriangleBasis(surface, c)
    return basis, c, EnclosedVolume(basis)


@pytest.mark.parametrize("degree", [2, 3])
def test_volume_of_raw_balls(degree):
    basis, c, volume = raw_ball(degree, 50)
    _, fine, finer_volume = raw_ball(degree, 200)
    exact = 4.0 / 3.0 * np.pi
    errors = [abs(v.value(x) / exact - 1.0) for v, x in ((volume, c), (finer_volume, fine))]
    assert errors[0] / errors[1] > 15.0  # h^4: 16
    assert errors[1] < 2e-4
    assert volume.value(c + 3.0) == pytest.approx(volume.value(c), rel=1e-12)
    assert coefficients_of(basis) == pytest.approx(c, abs=1e-11)
    assert basis.mass(2.0).sum() == pytest.approx(6.0 * basis.dx.sum())


def test_mechanism_and_pieces():
    basis, _ = flat(2)
    everything = extraction(basis.surface.reduction)
    assert mechanism(everything, basis).motions.shape[0] == 6
    rim = (3 * basis.surface.rim_coefficients[:, None] + np.arange(3)).ravel()
    assert mechanism(extraction(basis.surface.reduction, rim), basis).motions.shape[0] == 0
    two = TriangleSurface(np.array([[0, 1, 2], [3, 4, 5]]), 2)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], float)
    apart, c = interpolated(corners, two.triangles, 2, lambda x: x)
    assert apart.pieces.tolist() == [0, 1]
    with pytest.raises(ValueError, match="piece"):
        mechanism(extraction(apart.reduction), TriangleBasis(apart, c)).refuse()


def test_degenerate_triangle_is_named():
    surface = TriangleSurface(np.array([[0, 1, 2], [1, 3, 2]]), 2)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 0]], float)
    _, c = interpolated(corners, surface.triangles, 2, lambda x: x)
    with pytest.raises(ValueError, match=r"1 element.*triangle 1 near"):
        TriangleBasis(surface, c)
