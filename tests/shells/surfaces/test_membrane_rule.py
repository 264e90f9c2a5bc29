"""The reduced rule around a periodic direction: how even, and what its alternatives cost."""

import numpy as np
import pytest

import shells
from cases.geometry.revolution import revolve, ring_space


def pressurised_tube(membrane, around, degree=3):
    """Radii of a tube's middle on 240 points under a pressure, its ends hinged."""
    s, t = shells.SplineSpace(np.linspace(0.0, 3.0, 9), degree), ring_space(degree, around)
    tube = shells.SplineSurface(s, t)
    c = revolve(np.stack([np.ones(s.n), -s.greville], axis=1), t)
    basis = shells.SurfaceBasis(tube, c)
    shell = shells.KirchhoffLove(basis, shells.Material(1e-4, poisson_ratio=0.3), membrane=membrane)
    E = shells.supported(tube, *(shells.hinge(tube, "s", end) for end in (0, 1)))
    structure = shells.ShellStructure(shell, E, shells.EnclosedVolume(basis))
    end = shells.minimise(structure, c, 0.05)
    assert end.ok
    assert end.iterations < 15
    angle = np.arange(240) / 240 * 2.0 * np.pi
    x = np.einsum(
        "i,qj,ijc->qc",
        s.evaluate(1.5)[0],
        t.evaluate(angle),
        end.state.coefficients.reshape(s.n, t.n, 3),
    )
    return np.hypot(x[:, 0], x[:, 1])


def test_tubes_come_out_even():
    """Gauss points to rounding; the reduced rule by two elements, by one far below the error."""
    exact = pressurised_tube("gauss", 24).mean()
    for membrane in ("gauss", "reduced"):
        radii = pressurised_tube(membrane, 12)
        error = np.abs(radii - exact).max()
        by_one, by_two = (np.abs(np.roll(radii, k * 20) - radii).max() for k in (1, 2))
        assert error < 7e-3 * (exact - 1.0)
        assert by_two < 1e-12
        assert by_one < (1e-12 if membrane == "gauss" else 0.1 * error)


@pytest.mark.parametrize(("degree", "least"), [(2, 0.65), (3, 0.94), (4, 0.98)])
def test_a_thin_tube_becomes_oval(degree, least):
    """Frequency of the inextensional mode of a ring, ``w^2 = D n^2 (n^2 - 1)^2 / (n^2 + 1)``."""
    D, found = 1e-7, {}
    s, t = shells.SplineSpace([0.0, 0.2], degree), ring_space(degree, 12)
    tube = shells.SplineSurface(s, t)
    c = revolve(np.stack([np.ones(s.n), -s.greville], axis=1), t)
    for membrane in ("gauss", "reduced"):
        shell = shells.KirchhoffLove(
            shells.SurfaceBasis(tube, c), shells.Material(D), membrane=membrane
        )
        structure = shells.ShellStructure(shell, shells.supported(tube))
        # six rigid motions, then both ovals; D / w^2 is the share of the exact flexibility
        found[membrane] = shells.lowest_modes(structure, c, 8).values[6:]
    exact = D * 4.0 * 9.0 / 5.0
    assert exact / found["reduced"].max() > least
    assert exact / found["gauss"].max() < 0.3
