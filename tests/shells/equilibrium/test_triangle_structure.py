"""Structures of triangles: the same supports, steps, modes and minima as of splines."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

import shells
from cases.benchmarks.meshes.raw import interpolated, rectangle
from cases.benchmarks.meshes.shells import ball, inflated, roof, shear, strip, zero_modes
from cases.benchmarks.shells.roof import CONVERGED
from cases.kinds.load_path.published import SHEAR_TABLE
from shells.conditions.triangle_edges import triangle_edge
from shells.equilibrium.state import ShellState


def flat_plate(n, degree=3, size=(1.0, 1.0)):
    points, triangles = rectangle(n, size=size)
    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, degree, lambda x: x)
    return shells.TriangleBasis(surface, c), c


def test_steps_hold_the_volume():
    basis, c = ball(40, 2)
    c = c * [1.0, 1.0, 0.5]
    basis = shells.TriangleBasis(basis.surface, c)
    shell = shells.TriangleShell(basis, shells.Material(1e-3, density=1.0))
    structure = shells.ShellStructure(
        shell, shells.extraction(basis.surface.reduction), shells.EnclosedVolume(basis)
    )
    state, start = ShellState(0.0, c, np.zeros_like(c)), structure.volume(c)
    for k in range(1, 4):
        step = structure.step(state, None, 1.0, start * (1.0 + 0.05 * k))
        assert step.ok, step.outcome
        assert step.newton_iterations <= 6
        state = step.state
        assert structure.volume(state.coefficients) == pytest.approx(
            start * (1.0 + 0.05 * k), rel=1e-12
        )
    energies = structure.energies(state)
    assert energies["bending"] > 0.0
    assert energies["membrane"] > 0.0
    assert np.abs(shell.change_of_kinks(state.coefficients)).max() < 0.2


def test_a_plane_of_symmetry_halves_the_shell():
    """On a mirrored mesh the whole has twice the energy of its half, kinks in the plane too."""
    points, triangles = rectangle(3)
    half = np.column_stack([points, np.zeros(len(points))])
    twin = half * [-1.0, 1.0, 1.0]
    on = np.abs(half[:, 0]) < 1e-12
    number = np.where(on, np.arange(len(half)), len(half) + np.cumsum(~on) - 1)
    both = np.concatenate([half, twin[~on]])
    whole = np.concatenate([triangles, number[triangles][:, [0, 2, 1]]])
    rng = np.random.default_rng(0)
    weights = rng.standard_normal((6, 3))

    def moved(x):
        """A motion that the mirror x -> -x keeps."""
        u, v = x[..., 0], x[..., 1]
        bend = np.stack([np.abs(u), u**2, v, v**2, np.abs(u) * v, v**3], axis=-1)
        y = x + 0.2 * bend @ weights
        across = u * (1.0 + 0.1 * v + 0.2 * np.abs(u))
        return np.stack([across, y[..., 1], y[..., 2]], axis=-1)

    material, energies = shells.Material(0.03, poisson_ratio=0.3), []
    for p, t in ((half, triangles), (both, whole)):
        surface, c = interpolated(p, t, 3, lambda x: x)
        _, theta = interpolated(p, t, 3, moved)
        held = None
        if len(p) == len(half):
            plane = shells.rim_edges(surface, c, lambda x: np.abs(x[..., 0]) < 1e-9)
            held = shells.HeldSlopes(plane, np.array([-1.0, 0.0, 0.0]))
        shell = shells.TriangleShell(shells.TriangleBasis(surface, c), material, clamp=held)
        energies.append(np.array(shell.energy(theta)))
        assert np.abs(shell.change_of_kinks(theta)).max() > 0.1
    assert energies[1] == pytest.approx(2.0 * energies[0], rel=1e-12)


def test_clamps_are_known_to_the_mechanism():
    basis, c = flat_plate(3)
    edge = shells.rim_edges(basis.surface, c, lambda x: x[..., 0] < 1e-9)
    E = shells.supported(basis.surface, shells.hold_edges(basis.surface, edge))
    material = shells.Material(1e-8)
    hinged = shells.ShellStructure(shells.TriangleShell(basis, material), E)
    assert hinged.mechanism.motions.shape[0] == 1
    clamped = shells.TriangleShell(basis, material, clamp=edge)
    assert shells.ShellStructure(clamped, E).mechanism.motions.shape[0] == 0
    free = shells.extraction(basis.surface.reduction)
    assert shells.ShellStructure(clamped, free).mechanism.motions.shape[0] == 5  # about the edge
    with pytest.raises(ValueError, match="none of"):
        shells.rim_edges(basis.surface, c, lambda x: x[..., 0] > 7.0)


def test_vibration_of_a_plate():
    basis, c = flat_plate(6)
    D = 1e-3
    shell = shells.TriangleShell(basis, shells.Material(D, poisson_ratio=0.3))
    rim = shells.hold_edges(basis.surface, basis.surface.graph.rim)
    structure = shells.ShellStructure(shell, shells.supported(basis.surface, rim))
    values = shells.lowest_modes(structure, c, 3).values
    exact = D * np.pi**4 * np.array([4.0, 25.0, 25.0])  # simply supported, unit density
    assert values == pytest.approx(exact, rel=3e-3)


def test_free_bodies_have_six_zero_modes():
    _, sixth, seventh, cost = zero_modes(25, 3)
    assert sixth < 1e-14
    assert seventh > 1e-4
    assert cost < 1e-26


def test_large_rotations_of_a_clamped_strip():
    tips, _ = shear(3)
    assert np.abs(tips - SHEAR_TABLE[:, 1:]).max() / SHEAR_TABLE[-1, 1:].max() < 1e-3


def test_roof():
    _, value = roof(12, 3)
    assert value == pytest.approx(CONVERGED, rel=5e-4)


def test_inflated_sphere():
    triangles, error, _ = inflated(50, 3)
    assert triangles == 96
    assert abs(error) < 3e-4


def octant(n):
    """Raw mesh of an eighth of the unit sphere, edges in the coordinate planes."""
    t = np.arange(n) / n
    sides = [np.stack(np.roll([t, 1.0 - t, 0.0 * t], k, axis=0), axis=1) for k in range(3)]
    inner = np.random.default_rng(0).dirichlet((2.0, 2.0, 2.0), n * n // 3)
    points = np.concatenate([*sides, inner[inner.min(axis=1) > 0.5 / n]])
    plane = points[:, :2] - points[:, 1:]
    triangles = Delaunay(plane).simplices
    normals = np.linalg.det(points[triangles])
    triangles[normals < 0.0] = triangles[normals < 0.0][:, ::-1]
    triangles = triangles[np.abs(normals) > 1e-9]
    return interpolated(
        points, triangles, 3, lambda x: x / np.linalg.norm(x, axis=-1, keepdims=True)
    )


def test_an_eighth_of_a_sphere_inflates():
    surface, c = octant(6)
    basis = shells.TriangleBasis(surface, c)
    planes = [shells.rim_edges(surface, c, lambda x, k=k: np.abs(x[..., k]) < 1e-12)
              for k in range(3)]  # fmt: skip
    assert sum(edges.size for edges in planes) == surface.graph.rim.size
    slopes = [shells.HeldSlopes(edges, -np.eye(3)[k]) for k, edges in enumerate(planes)]
    held = [shells.hold_edges(surface, edges, (k,)) for k, edges in enumerate(planes)]
    D, nu = 1e-3, 0.3
    shell = shells.TriangleShell(basis, shells.Material(D, poisson_ratio=nu), clamp=slopes)
    E, volume = shells.supported(surface, *held), shells.EnclosedVolume(basis)
    structure = shells.ShellStructure(shell, E, volume)
    assert structure.mechanism.motions.shape[0] == 0
    # membrane and, with kappa = stretch - 1, bending of a sphere
    stretch = 1.2
    pressure = (1.0 + nu) * ((stretch**2 - 1.0) / stretch + 2.0 * D * (stretch - 1.0) / stretch**2)
    end = shells.minimise(structure, c, pressure)
    assert end.ok, end.failure
    x = end.state.coefficients
    ratio = structure.volume(x) / structure.volume(c)
    assert ratio ** (1.0 / 3.0) == pytest.approx(stretch, rel=2e-4)
    unheld = shells.ShellStructure(
        shells.TriangleShell(basis, shells.Material(D, poisson_ratio=nu)), E, volume
    )
    loose = shells.minimise(unheld, c, pressure).state.coefficients
    assert np.abs(loose - x).max() > 1e-4  # without the planes the rim turns
    with pytest.raises(ValueError, match=r"edge \(\d+, \d+\) is open and moves"):
        shells.ShellStructure(shell, shells.extraction(surface.reduction), volume)


def test_cloth_of_triangles_wrinkles():
    basis, c = flat_plate(3, degree=2)
    cloth = shells.TriangleShell(basis, shells.Material(0.0), compression_share=1e-3)
    theta = c * [1.1, 0.8, 1.0]
    assert np.all(shells.wrinkling(cloth, theta).state == 1)
    plain = shells.TriangleShell(basis, shells.Material(0.0))
    assert sum(cloth.energy(theta)) < sum(plain.energy(theta))
    assert shells.stress(plain, theta).stretches[0, 0] == pytest.approx([1.1, 0.8])


def test_end_moment_rolls_a_strip():
    """``D kappa = m`` along a strip whose far end turns by ``m L / D``."""
    points, triangles = strip(9)
    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, 3, lambda x: x)
    basis, D, turn = shells.TriangleBasis(surface, c), 1e-3, 0.5
    root, tip = (
        shells.rim_edges(surface, c, lambda x, at=at: np.abs(x[..., 0] - at) < 1e-9)
        for at in (0.0, 10.0)
    )
    shell = shells.TriangleShell(basis, shells.Material(D), clamp=root)
    structure = shells.ShellStructure(
        shell, shells.supported(surface, shells.hold_edges(surface, root))
    )
    edge = triangle_edge(surface, tip, c)
    end = structure.static(c, load=lambda x: edge.moment(x.reshape(-1, 3), turn * D / 10.0))
    assert end.ok, end.outcome
    found = end.state.coefficients[c[:, 0] > 10.0 - 1e-9]
    radius = 10.0 / turn
    lift = radius * (1.0 - np.cos(turn))
    assert found[:, 2] == pytest.approx(lift, rel=2e-2)
