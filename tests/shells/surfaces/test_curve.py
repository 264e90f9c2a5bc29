"""Planar membranes: derivatives, remark 10, enclosed area, supports, an arc under pressure."""

import numpy as np
import pytest

from shells.conditions.curve_ends import end_supports
from shells.energy.area import EnclosedArea
from shells.energy.elastic_string import ElasticString
from shells.energy.material import Material
from shells.energy.planar_shell import PlanarShell
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.curve import CurveBasis, rot


def arc(n=16, angle=1.9 * np.pi, radius=2.0):
    s = np.linspace(0.0, radius * angle, n + 1)
    a = s / radius - 0.95 * np.pi - np.pi / 2
    points = radius * np.column_stack([np.cos(a), np.sin(a)])
    tangents = np.column_stack([-np.sin(a), np.cos(a)])
    return s, np.stack([points, tangents], axis=1).reshape(-1, 2)


@pytest.mark.parametrize("law", [PlanarShell, ElasticString])
def test_variations_match_differences(law):
    s, c = arc()
    membrane = law(CurveBasis(s, c), Material(1e-2, 2.0))
    rng = np.random.default_rng(0)
    x = c.ravel() + 0.05 * rng.standard_normal(c.size)
    d = rng.standard_normal(c.size)
    e = 1e-6
    energy = [sum(membrane.energy(x + sign * e * d)) for sign in (1, -1)]
    gradient = [membrane.gradient(x + sign * e * d) for sign in (1, -1)]
    g, H = membrane.gradient_and_tangent(x)
    assert abs((energy[0] - energy[1]) / (2 * e) - g @ d) < 1e-7 * abs(g @ d)
    change = (gradient[0] - gradient[1]) / (2 * e)
    assert np.abs(change - H @ d).max() < 1e-7 * np.abs(change).max()
    assert np.abs(H - H.T).max() < 1e-12 * np.abs(H).max()


def test_remark_10():
    """Axial forces of both laws differ by 3/2 k e^2 [T remark 10]."""
    s = np.linspace(0.0, 1.0, 3)
    c = np.stack(
        [np.column_stack([s, 0 * s]), np.column_stack([np.ones(3), np.zeros(3)])], axis=1
    ).reshape(-1, 2)
    basis = CurveBasis(s, c)
    difference = []
    for e in (1e-2, 5e-3):
        end = [
            law(basis, Material(0.0)).gradient((1 + e) * c.ravel())[8]
            for law in (PlanarShell, ElasticString)
        ]
        difference.append(end[0] - end[1])
        assert abs(difference[-1] / e**2 - 1.5) < 2 * e
    assert 1.95 < np.log2(difference[0] / difference[1]) < 2.05


def test_enclosed_area():
    s, c = arc(64)
    area = EnclosedArea(CurveBasis(s, c))
    chord = 4.0 * np.sin(0.05 * np.pi)
    exact = 4.0 * 0.95 * np.pi + 0.5 * chord * 2.0 * np.cos(0.05 * np.pi)
    assert abs(area.value(c) / exact - 1.0) < 5e-7  # measured 2e-7, interpolation of the arc
    x, d = c.ravel(), np.random.default_rng(1).standard_normal(c.size)
    value, gradient, hessian = area.derivatives(x)
    # quadratic: the expansion is exact
    assert abs(area.value(x + d) - value - gradient @ d - 0.5 * d @ (hessian @ d)) < 1e-12 * x.size
    shift = np.tile([1.0, 0.0, 0.0, 0.0], s.size)
    assert abs(gradient @ shift) < 1e-10  # translations keep the area


def test_clamped_ends_keep_their_direction():
    _, c = arc()
    E = end_supports(c, "clamped")
    q = np.random.default_rng(2).standard_normal(E.shape[1])
    moved = c + (E @ q).reshape(-1, 2)
    assert np.all(moved[[0, -2]] == c[[0, -2]])
    for k in (1, -1):
        assert abs(moved[k] @ rot(c[k])) < 1e-12
    with pytest.raises(ValueError, match="hinged"):
        end_supports(c, "glued")


def test_pressure_of_an_overinflated_arc():
    """``p = N / R``, N = k s (s^2 - 1) / 2 [T 2.21] without bending, hinged ends."""
    s, c = arc(48)
    basis = CurveBasis(s, c)
    shell = PlanarShell(basis, Material(1e-8, 2.0))
    structure = ShellStructure(shell, end_supports(c), EnclosedArea(basis))
    step = structure.static(c, 1.05 * structure.volume(c), pressure=0.01)
    assert step.ok
    stretch = float(shell.stretch(step.state.coefficients).mean())
    jets = basis.jets(step.state.coefficients)
    curvature = (
        np.abs((rot(jets.tangent) * jets.second).sum(axis=-1))
        / np.linalg.norm(jets.tangent, axis=-1) ** 3
    )
    force = stretch * (stretch**2 - 1.0)
    assert abs(step.state.pressure / (force * curvature.mean()) - 1.0) < 1e-3
