"""Tension field: exact states, derivatives at and between them, simple shear of a strip."""

import numpy as np
import pytest

import shells
from shells.energy.densities import StVenantKirchhoff, TensionField, relaxed
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material

NU = 0.3
MATERIAL = Material(0.02, 1.7, NU)
# principal strains of each state, then of its borders: taut | wrinkled, wrinkled | slack, corner
TAUT, WRINKLED, SLACK = (0.1, -0.02), (0.1, -0.2), (-0.05, -0.1)
BORDERS = {"taut": (0.1, -0.1 * NU), "slack": (0.0, -0.1), "rest": (0.0, 0.0)}


def strain(principal, angle=0.4):
    e1, e2 = principal
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    m, r = 0.5 * (e1 + e2), 0.5 * (e1 - e2)
    return np.array([m + r * c, m - r * c, 2.0 * r * s])


def energy(e, k):
    return relaxed(MATERIAL, e, k)[2][0]


@pytest.mark.parametrize(
    ("principal", "state", "value", "forces"),
    [
        (TAUT, 0, (0.01 + 0.0004 - 0.004 * NU) / 2, (0.1 - 0.02 * NU, -0.02 + 0.1 * NU)),
        (WRINKLED, 1, (1 - NU**2) * 0.01 / 2, ((1 - NU**2) * 0.1, 0.0)),
        (SLACK, 2, 0.0, (0.0, 0.0)),
    ],
)
def test_states(principal, state, value, forces):
    found, strains, (psi, n, D) = relaxed(MATERIAL, strain(principal), 0.0)
    assert found == state
    assert strains == pytest.approx(principal)
    assert psi == pytest.approx(1.7 * value, abs=1e-17)
    assert np.linalg.eigvalsh([[n[0], n[2]], [n[2], n[1]]]) == pytest.approx(
        1.7 * np.array(forces[::-1]), abs=1e-16
    )
    assert np.linalg.eigvalsh(D).min() > -1e-15


@pytest.mark.parametrize("k", [0.0, 1e-3])
@pytest.mark.parametrize("principal", [TAUT, WRINKLED, SLACK])
def test_derivatives_inside_a_state(principal, k):
    e = strain(principal)
    _, _, (_, n, D) = relaxed(MATERIAL, e, k)
    steps = 1e-5 * np.eye(3)
    slope = (energy(e + steps, k) - energy(e - steps, k)) / 2e-5
    forces = [relaxed(MATERIAL, e + sign * steps, k)[2][1] for sign in (1, -1)]
    assert n == pytest.approx(slope, abs=1e-10)
    assert np.abs((forces[0] - forces[1]) / 2e-5 - D).max() < 1e-9


@pytest.mark.parametrize("k", [0.0, 1e-3])
@pytest.mark.parametrize("border", BORDERS.values(), ids=BORDERS)
def test_derivatives_at_borders(border, k):
    """W_r is C1; from each side the stress has the slope of the tangent on that side."""
    e = strain(border)
    _, _, (value, n, _) = relaxed(MATERIAL, e, k)
    for towards in (TAUT, WRINKLED, SLACK):
        d = strain(towards) - e
        slopes = [(energy(e + h * d, k) - value) / h for h in (1e-5, 1e-6)]
        assert n @ d == pytest.approx((10 * slopes[1] - slopes[0]) / 9, abs=1e-9)
        _, _, (_, forces, D) = relaxed(MATERIAL, e + 1e-7 * d, k)
        assert forces == pytest.approx(n, abs=1e-6)  # continuous
        _, _, (_, further, _) = relaxed(MATERIAL, e + 2e-7 * d, k)
        assert (further - forces) / 1e-7 == pytest.approx(D @ d, abs=1e-6)
        assert np.linalg.eigvalsh(D).min() > -1e-15


def cone():
    """A conical sheet, and a rough configuration near it with points of all states."""
    s, t = shells.SplineSpace(np.linspace(0, 1, 4), 2), shells.SplineSpace(np.linspace(0, 1, 5), 2)
    surface = shells.SplineSurface(s, t)
    a, h = np.tile(t.greville, s.n), np.repeat(s.greville, t.n)
    X = np.stack([(1 + 0.3 * h) * np.cos(a), (1 + 0.3 * h) * np.sin(a), h], axis=1)
    rng = np.random.default_rng(1)
    return shells.SurfaceBasis(surface, X), X, X + 0.05 * rng.standard_normal(X.shape), rng


@pytest.mark.parametrize("rigidity", [0.0, 0.02])
@pytest.mark.parametrize("membrane", ["gauss", "reduced"])
def test_variations_of_the_fused_kernel(membrane, rigidity):
    basis, _, theta, rng = cone()
    shell = KirchhoffLove(
        basis, Material(rigidity, 1.7, NU), membrane=membrane, compression_share=0.01
    )
    states = shells.wrinkling(shell, theta).state
    assert set(states.ravel()) == {0, 1, 2}
    d = rng.standard_normal(theta.size)
    gradient, tangent = shell.gradient_and_tangent(theta)
    x, step = theta.ravel(), 1e-6
    slope = (sum(shell.energy(x + step * d)) - sum(shell.energy(x - step * d))) / (2 * step)
    curve = (shell.gradient(x + step * d) - shell.gradient(x - step * d)) / (2 * step)
    assert gradient @ d == pytest.approx(slope, rel=1e-7)
    assert tangent @ d == pytest.approx(curve, rel=1e-4, abs=1e-5)
    assert abs(tangent - tangent.T).max() < 1e-13


@pytest.mark.parametrize("k", [0.0, 1e-3, 1.0])
def test_kernel_and_density_agree(k):
    basis, _, theta, _ = cone()
    fused = KirchhoffLove(basis, MATERIAL, compression_share=k)
    density = TensionField(MATERIAL, k) if k < 1.0 else StVenantKirchhoff(MATERIAL)
    pointwise = HyperelasticShell(basis, density)
    assert sum(fused.energy(theta)) == pytest.approx(sum(pointwise.energy(theta)), rel=1e-13)
    a, b = fused.gradient_and_tangent(theta), pointwise.gradient_and_tangent(theta)
    assert np.abs(a[0] - b[0]).max() < 1e-13
    assert abs(a[1] - b[1]).max() < 1e-12


@pytest.mark.parametrize("path", ["kernel", "density"])
@pytest.mark.parametrize("shear", [0.01, 0.5, 1.0])
def test_simple_shear_of_a_strip(path, shear):
    """Force (1 - nu^2) C e1 de1/dg with e1 = g^2/4 + (g/2) sqrt(1 + g^2/4)."""
    space = shells.SplineSpace(np.linspace(0, 1, 4), 2)
    sheet = shells.SplineSurface(space, space)
    X = np.array([[a, b, 0.0] for a in space.greville for b in space.greville])
    basis, mode = shells.SurfaceBasis(sheet, X), np.zeros_like(X)
    mode[:, 0] = X[:, 1]
    material = Material(0.0, 1.7, NU)
    shell = (
        KirchhoffLove(basis, material, compression_share=0.0)
        if path == "kernel"
        else HyperelasticShell(basis, TensionField(material, 0.0))
    )
    root = np.sqrt(1 + shear**2 / 4)
    e1, slope = shear**2 / 4 + shear / 2 * root, shear / 2 + root / 2 + shear**2 / (8 * root)
    gradient, tangent = shell.gradient_and_tangent(X + shear * mode)
    exact = (1 - NU**2) * 1.7 * e1 * slope
    assert gradient @ mode.ravel() == pytest.approx(exact, rel=1e-13)
    curve = -(shear**3) / (32 * root**3) + shear / (4 * root) + shear / (8 * root) + 0.5
    assert mode.ravel() @ (tangent @ mode.ravel()) == pytest.approx(
        (1 - NU**2) * 1.7 * (slope**2 + e1 * curve), rel=1e-12
    )


def test_stress_and_refusals():
    basis, X, _, _ = cone()
    shell = KirchhoffLove(basis, MATERIAL, compression_share=0.0)
    assert np.abs(shells.stress(shell, 0.9 * X).membrane).max() == 0.0
    assert np.all(shells.wrinkling(shell, 0.9 * X).state == 2)
    assert np.all(shells.wrinkling(shell, 1.1 * X).state == 0)
    plain = KirchhoffLove(basis, MATERIAL)
    assert np.all(shells.stress(plain, 0.9 * X).membrane[..., :2] < 0.0)
    with pytest.raises(ValueError, match="compression_share = 2"):
        KirchhoffLove(basis, MATERIAL, compression_share=2.0)
    with pytest.raises(ValueError, match="compression_share = -1"):
        TensionField(MATERIAL, -1.0)
    classical = {"formulation": "classical"}
    with pytest.raises(ValueError, match="parametrization-free"):
        KirchhoffLove(basis, MATERIAL, compression_share=0.5, **classical)
    with pytest.raises(ValueError, match="parametrization-free"):
        shells.wrinkling(KirchhoffLove(basis, MATERIAL, **classical), X)
