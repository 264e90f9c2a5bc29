"""Shells of triangles: variations, rigid motions, edges that are held, soft, creased or absent."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import shells
from cases.benchmarks.meshes.plates import plate
from cases.benchmarks.meshes.raw import interpolated, rectangle, sphere
from shells.energy.kinks.edge_geometry import kink_angles
from shells.energy.kinks.edge_tables import HeldSlopes
from shells.energy.kinks.triangle_shell import TriangleShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.surfaces.triangles.triangle_basis import TriangleBasis

MATERIAL = Material(0.03, poisson_ratio=0.3)


def ball(degree, n=24):
    surface, c = interpolated(
        *sphere(n), degree, lambda x: x / np.linalg.norm(x, axis=-1, keepdims=True)
    )
    return TriangleBasis(surface, c), c


def sheet(degree, n=3, rounds=3):
    points, triangles = rectangle(n, rounds=rounds)
    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, degree, lambda x: x)
    return TriangleBasis(surface, c), c


def central(function, x, direction, step):
    plus, minus = function(x.ravel() + step * direction), function(x.ravel() - step * direction)
    return (plus - minus) / (2.0 * step)


def variations(shell, theta, direction):
    """Relative errors of gradient and tangent at two steps."""
    gradient, tangent = shell.gradient_and_tangent(theta)
    errors = []
    for step in (1e-4, 1e-5):
        slope = central(lambda x: sum(shell.energy(x)), theta, direction, step)
        curve = central(shell.gradient, theta, direction, step)
        product = tangent @ direction
        errors.append(
            [
                abs(slope / (gradient @ direction) - 1.0),
                np.linalg.norm(curve - product) / np.linalg.norm(product),
            ]
        )
    return np.array(errors), tangent


@pytest.mark.parametrize("degree", [2, 3])
def test_variations_by_finite_differences(degree):
    basis, c = ball(degree)
    rng = np.random.default_rng(0)
    shell = TriangleShell(basis, MATERIAL)
    errors, tangent = variations(
        shell, c + 0.03 * rng.standard_normal(c.shape), rng.standard_normal(c.size)
    )
    assert np.all(errors[0] / errors[1] > 90.0)  # central differences
    assert np.all(errors[1] < 1e-6)
    assert abs(tangent - tangent.T).max() < 1e-12


def test_variations_of_held_soft_and_creased_edges():
    basis, c = sheet(3)
    graph, rng = basis.surface.graph, np.random.default_rng(1)
    clamp = [HeldSlopes(graph.rim[:3]), HeldSlopes(graph.rim[3:5], np.array([0.1, 0.2, 1.0]))]
    soft, kinks = rng.uniform(size=(2, len(graph.triangles)))
    shell = TriangleShell(basis, MATERIAL, clamp=clamp, soft=soft, kinks=kinks)
    errors, tangent = variations(
        shell, c + 0.01 * rng.standard_normal(c.shape), rng.standard_normal(c.size)
    )
    assert np.all(errors[1] < 1e-6)
    assert abs(tangent - tangent.T).max() < 1e-12


@pytest.mark.parametrize("degree", [2, 3])
def test_rigid_motions_cost_nothing_and_nothing_else_does(degree):
    basis, c = ball(degree)
    shell = TriangleShell(basis, MATERIAL)
    turn = Rotation.random(random_state=1).as_matrix()
    assert max(shell.energy(c @ turn.T + 0.5)) < 1e-26
    theta = c + 0.05 * np.random.default_rng(2).standard_normal(c.shape)
    assert shell.energy(theta @ turn.T + 0.5) == pytest.approx(shell.energy(theta), rel=1e-13)
    values = np.linalg.eigvalsh(shell.gradient_and_tangent(c)[1].toarray())
    assert np.all(np.abs(values[:6]) < 1e-12 * values[-1])
    assert values[6] > 1e-5 * values[-1]


def test_plate_converges_on_raw_meshes():
    coarse, fine = plate(5, 3), plate(10, 3)
    rate = 2.0 * np.log(coarse.h2 / fine.h2) / np.log(fine.triangles / coarse.triangles)
    assert rate > 1.75
    assert fine.h2 < 9e-3
    assert fine.l2 < 1.2e-4
    assert 0.2 < fine.regular < 0.4  # raw it is


@pytest.mark.parametrize(("degree", "least"), [(2, 3.0), (3, 9.0)])
def test_stable_on_slivers(degree, least):
    """No mode of negative energy at the proven eta, whatever the triangles look like."""
    basis, c = sheet(degree, n=5, rounds=0)
    areas = basis.dx.sum(axis=1)
    assert areas.max() > 20.0 * areas.min()
    material = Material(1.0, poisson_ratio=0.45)
    values = {}
    for eta in (least / 9.0, least):
        shell = TriangleShell(basis, material, stabilisation=eta)
        bending = shell.gradient_and_tangent(c)[1][2::3, 2::3].toarray()
        values[eta] = np.linalg.eigvalsh(bending)
    assert values[least / 9.0][0] < -1e-3 * values[least][-1]
    assert values[least][0] > -1e-14 * values[least][-1]
    assert values[least][3] > 0.0


@pytest.mark.parametrize("degree", [2, 3])
def test_patch(degree):
    """A deflection of the degree bends without force: ``div div M = 0``, and moments agree."""
    basis, c = sheet(degree, n=6)
    surface = basis.surface
    points, triangles = rectangle(6)
    flat = np.column_stack([points, np.zeros(len(points))])

    def polynomial(p):
        x, y = p[..., 0], p[..., 1]
        w = 0.3 * x**2 - x * y + 0.7 * y**2
        return (w + (x**3 - 2.0 * x * y**2 if degree == 3 else 0.0))[..., None]

    _, w = interpolated(flat, triangles, degree, polynomial)
    K = TriangleShell(basis, MATERIAL).gradient_and_tangent(c)[1][2::3, 2::3]
    force = K @ w[:, 0]
    on_rim = np.isin(surface.element_dofs, surface.rim_coefficients).any(axis=1)
    inside = np.setdiff1d(np.arange(len(c)), surface.element_dofs[on_rim])
    assert inside.size > 20
    assert np.abs(force).max() > 1e-3  # at the rim
    assert np.abs(force[inside]).max() < 1e-14 * abs(K).max()


def test_two_triangles_back_to_back():
    """A closed bag of two triangles: all three edges are those of both."""
    surface, c = interpolated(
        np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        np.array([[0, 1, 2], [0, 2, 1]]),
        3,
        lambda x: x,
    )
    c[surface.element_dofs[:, 4], 2] = [0.5, -0.5]  # the inner control points
    rng = np.random.default_rng(5)
    shell = TriangleShell(TriangleBasis(surface, c), MATERIAL)
    assert shell.edges.size == 3
    theta = c + 0.03 * rng.standard_normal(c.shape)
    errors, _ = variations(shell, theta, rng.standard_normal(c.size))
    assert np.all(errors[1] < 1e-6)


def test_without_rigidity_no_edge_carries_energy():
    basis, c = sheet(2)
    theta = c + 0.05 * np.random.default_rng(3).standard_normal(c.shape)
    membrane = Material(0.0)
    shell = TriangleShell(basis, membrane)
    assert shell.edges.size == 0
    assert shell.energy(theta) == KirchhoffLove(basis, membrane).energy(theta)
    assert TriangleShell(basis, MATERIAL).edges.size == np.sum(
        basis.surface.graph.triangles[:, 1] >= 0
    )


def folded(c, degrees):
    """A sheet bent sharply along the edges nearest to x = 1/2: coefficients of a straight ramp."""
    angle = np.deg2rad(degrees)
    beyond = np.maximum(c[:, 0] - 0.5, 0.0)
    return np.column_stack(
        [
            np.minimum(c[:, 0], 0.5) + beyond * np.cos(angle),
            c[:, 1],
            beyond * np.sin(angle),
        ]
    )


def halves():
    """Two squares that share the edge x = 1/2, four triangles, cubic."""
    points = np.array([[0, 0], [0.5, 0], [1, 0], [0, 1], [0.5, 1], [1, 1]], dtype=float)
    triangles = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    flat = np.column_stack([points, np.zeros(6)])
    surface, c = interpolated(flat, triangles, 3, lambda x: x)
    return TriangleBasis(surface, c), c


@pytest.mark.parametrize("degrees", [60.0, 150.0, -150.0])
def test_kinks_are_angles_and_creases_set(degrees):
    basis, c = halves()
    bent = folded(c, degrees)
    kinks = kink_angles(basis.surface, bent)
    at = np.flatnonzero(np.abs(kinks).max(axis=1) > 1e-9)
    assert basis.surface.graph.vertices[at].tolist() == [[1, 4]]
    assert np.abs(np.rad2deg(kinks[at])) == pytest.approx(abs(degrees), abs=1e-9)
    stiff, set_crease = TriangleShell(basis, MATERIAL), TriangleShell(basis, MATERIAL, kinks=kinks)
    size = 20.0 * 0.03 * np.deg2rad(degrees) ** 2 / (2.0 * 0.5)  # h = (A1 + A2) / |e|
    assert sum(stiff.energy(bent)) == pytest.approx(size, rel=1e-10)
    assert sum(set_crease.energy(bent)) == pytest.approx(0.0, abs=1e-14)
    soft = np.ones(len(kinks))
    soft[at] = 0.0
    line = TriangleShell(basis, MATERIAL, soft=soft)
    assert sum(line.energy(bent)) == pytest.approx(0.0, abs=1e-14)
    assert set(stiff.edges) - set(line.edges) == set(at)


def test_creases_of_the_reference_are_free_of_stress():
    basis, c = halves()
    bent = folded(c, 100.0)
    creased = TriangleShell(TriangleBasis(basis.surface, bent), MATERIAL)
    assert sum(creased.energy(bent)) < 1e-26
    cut_flat = TriangleShell(TriangleBasis(basis.surface, bent), MATERIAL, curvature=c)
    flat = TriangleShell(basis, MATERIAL)
    assert sum(cut_flat.energy(bent)) == pytest.approx(sum(flat.energy(bent)), rel=1e-12)
    assert np.rad2deg(np.abs(cut_flat.change_of_kinks(bent)).max()) == pytest.approx(100.0)


def test_beyond_half_a_turn_angles_go_on():
    """The change of a kink counts, not the kink: from 170 degrees on to 190 is 20."""
    basis, c = halves()
    start, end = (folded(c, degrees) for degrees in (170.0, 190.0))
    shell = TriangleShell(TriangleBasis(basis.surface, start), MATERIAL)
    assert np.rad2deg(np.abs(shell.change_of_kinks(end)).max()) == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"soft": np.full(9, 1.5)}, "shares of the bending"),
        ({"soft": np.ones(3)}, "for each of 9 edges"),
        ({"kinks": np.ones(4)}, "kinks: expected"),
        ({"clamp": np.arange(9)}, "no rim edge"),
    ],
)
def test_refused(options, words):
    basis, _ = halves()
    with pytest.raises(ValueError, match=words):
        TriangleShell(basis, MATERIAL, **options)


def test_triangles_without_ties_are_refused():
    basis, c = halves()
    surface = basis.surface
    with pytest.raises(ValueError, match="hold_edges"):
        shells.clamp(surface, "s", 0)
    with pytest.raises(ValueError, match="edge_load"):
        shells.line_load(surface, "s", 0, [0.0, 0.0, 1.0], c)
    line = shells.SplineSpace([0.0, 1.0], 2)
    spline = shells.SplineSurface(line, line)
    flat = np.array([[x, y, 0.0] for x in line.greville for y in line.greville])
    with pytest.raises(ValueError, match="takes a TriangleBasis"):
        TriangleShell(shells.SurfaceBasis(spline, flat), MATERIAL)
    with pytest.raises(ValueError, match="TriangleShell"):
        KirchhoffLove(basis, MATERIAL)
    with pytest.raises(ValueError, match="no reduced membrane rule"):
        KirchhoffLove(basis, Material(0.0), membrane="reduced")


def test_a_clamp_holds_where_the_shell_is_not_where_its_reference_lies():
    """The reference is turned away and moved; at its place the clamped shell is at rest."""
    basis, c = sheet(3)
    bent = c + 0.1 * np.column_stack([0 * c[:, 0], 0 * c[:, 0], c[:, 0] ** 2])
    turned = c @ Rotation.from_rotvec([0.4, 2.0, -1.0]).as_matrix().T + [5.0, 1.0, -2.0]
    rim = basis.surface.graph.rim
    elsewhere = TriangleBasis(basis.surface, turned)
    there = TriangleShell(elsewhere, MATERIAL, clamp=HeldSlopes(rim, at=c))
    here = TriangleShell(basis, MATERIAL, clamp=HeldSlopes(rim))
    assert sum(there.energy(c)) < 1e-25
    assert there.energy(bent)[1] == pytest.approx(here.energy(bent)[1], rel=1e-10)
    assert sum(TriangleShell(elsewhere, MATERIAL, clamp=rim).energy(c)) > 1e-3
