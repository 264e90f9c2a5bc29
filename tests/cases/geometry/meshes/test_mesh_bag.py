"""A bag from a mesh: the inlet cut out, one rim for both sides, inflow, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.inlets.facing import first_hits
from cases.geometry.meshes.inlets.inflow import RimCurve, inflow_profile
from cases.geometry.meshes.mesh_bag import mesh_bag
from shells.surfaces.local_elements import lattice
from shells.surfaces.splines import bernstein

XI, ETA, _ = lattice("triangle", 6)
LOW = {"plane": [0.0, 0.0, -1.0, 0.8]}


def centroids(mesh: FacetMesh) -> np.ndarray:
    return mesh.points[mesh.triangles].mean(axis=1)


@pytest.mark.parametrize("degree", [2, 3])
def test_membrane_and_inlet_have_one_rim(bodies, degree: int) -> None:
    bag = mesh_bag(bodies.raw_sphere(200), inlet=LOW, degree=degree, density=2, split=1)
    mine = bag.coefficients[bag.membrane.on_edges(bag.rim.membrane)]
    theirs = bag.coefficients[bag.n_membrane + bag.inlet.on_edges(bag.rim.inlet)]
    assert np.array_equal(mine, theirs[:, ::-1])
    assert bag.rim.membrane.size == bag.membrane.graph.rim.size == bag.inlet.graph.rim.size > 20
    assert bag.inlet.n_elements == bag.patch.size
    held = bag.support("hinged")
    assert held.shape == (3 * len(bag.coefficients),
                          3 * (bag.n_membrane - bag.membrane.rim_coefficients.size))  # fmt: skip
    assert not np.diff(held.indptr).reshape(-1, 3)[bag.membrane.rim_coefficients].any()
    with pytest.raises(ValueError, match="not 'glued'"):
        bag.support("glued")


def test_numbers_of_a_bag(bodies) -> None:
    body, volume = bodies.pancake(24)
    bag = mesh_bag(body, inlet="inlet")
    assert abs(bag.exact_volume / volume - 1.0) < 2e-4
    assert bag.gap == pytest.approx(0.85, abs=0.01)  # 2 V / A, sheets 1 apart
    assert bag.extent == pytest.approx(4.77, abs=0.01)
    assert 0.9 < bag.narrowest <= 1.0 + 1e-9
    assert bag.faces == np.inf
    assert bag.warnings == ()
    assert "no group 'inlet', took 'Inlet'" in bag.notes[0]
    assert bag.fit_error == bag.mesh.moved > 0.04
    x = bag.inlet.sample(XI, ETA) @ bag.coefficients[bag.n_membrane :]
    assert np.abs(x[:, 2] + 0.5).max() < 1e-12
    inflow = bag.profile(x)
    assert inflow.min() >= 0.0
    assert inflow.max() == pytest.approx(1.0, abs=1e-9)
    parabola = 1.0 - x[:, 0] ** 2 - x[:, 1] ** 2  # the rim is a polygon of 24 edges here
    assert np.abs(inflow - parabola).max() < 0.02


def test_the_inflow_is_zero_at_a_curved_rim(bodies) -> None:
    bag = mesh_bag(bodies.raw_sphere(200), inlet=LOW)
    rim = bag.coefficients[bag.n_membrane + bag.inlet.on_edges(bag.rim.inlet)]
    on_rim = (bernstein(3, np.linspace(0.0, 1.0, 33)).T @ rim).reshape(-1, 3)
    assert bag.profile(on_rim).max() < 1e-14


def test_distance_from_a_curve_of_uneven_edges() -> None:
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 0.1, 0], [1, 1, 0], [0, 1, 0]], float)
    following = np.roll(corner, -1, axis=0)
    t = np.arange(4)[:, None, None] / 3.0
    curve = RimCurve(np.moveaxis(corner + t * (following - corner), 0, 1))
    x = np.random.default_rng(0).uniform(0.0, 1.0, (500, 3)) * [1.0, 1.0, 0.0]
    exact = np.minimum(x, 1.0 - x)[:, :2].min(axis=1)
    assert np.abs(curve.distance(x) - exact).max() < 1e-9
    profile = inflow_profile(curve, x)
    assert profile(x).max() == 1.0
    assert profile(corner).max() < 1e-14


def test_a_disc_has_the_parabola() -> None:
    angle = 2.0 * np.pi * np.arange(24) / 24.0
    reach = 4.0 / 3.0 * np.tan(np.pi / 48.0)
    at = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = np.stack([-at[:, 1], at[:, 0], at[:, 2]], axis=1)
    end, end_along = np.roll(at, -1, axis=0), np.roll(along, -1, axis=0)
    curve = RimCurve(np.stack([at, at + reach * along, end - reach * end_along, end], axis=1))
    r = np.linspace(0.0, 1.0, 50)
    x = np.stack([r * np.cos(7 * r), r * np.sin(7 * r), 0 * r], axis=1)
    assert np.abs(inflow_profile(curve, x)(x) - (1.0 - r**2)).max() < 5e-7  # measured 2.6e-7


def test_a_hole_is_capped(bodies) -> None:
    sphere = bodies.raw_sphere(200)
    low = centroids(sphere)[:, 2] < -0.8
    torn = bodies.without(sphere, low)
    whole, bag = mesh_bag(sphere, inlet=LOW), mesh_bag(torn, inlet="hole")
    assert bag.membrane.n_elements == whole.membrane.n_elements
    assert "was capped by" in bag.notes[0]
    assert bag.exact_volume < whole.exact_volume
    x = bag.inlet.sample(np.array([1.0 / 3.0]), np.array([1.0 / 3.0]))
    assert (x @ bag.coefficients[bag.n_membrane :])[:, 2].max() < -0.7
    assert np.array_equal(bag.mesh.facets.groups["cap of the hole"], bag.patch)
    both = bodies.without(sphere, low | (centroids(sphere)[:, 2] > 0.9))
    with pytest.raises(MeshError, match=r'"hole": the mesh has 2 holes \(.*hole = \[x, y, z\]'):
        mesh_bag(both, inlet="hole")
    with pytest.raises(MeshError, match=r"another hole .*\(.* centre .*, 0\.\d+\)\): close"):
        mesh_bag(both, inlet={"hole": [0, 0, -1]})
    with pytest.raises(MeshError, match=r'a hole \(\d+ edges, length .*inlet = "hole"'):
        mesh_bag(torn)
    with pytest.raises(MeshError, match="the mesh is closed"):
        mesh_bag(sphere, inlet="hole")


def test_a_patch_that_faces_a_sheet(bodies) -> None:
    """A bowl: the inlet on its inside looks at the other side."""
    turn = np.linspace(-0.5 * np.pi, 0.4 * np.pi, 15)
    outer = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    r = np.concatenate([[0.0], outer[1:, 0], 0.8 * outer[:0:-1, 0], [0.0]])
    z = np.concatenate([[-1.0], outer[1:, 1], 0.8 * outer[:0:-1, 1], [-0.8]])
    bowl = bodies.revolved(r, z, 16)
    inner = np.linalg.norm(centroids(bowl), axis=1) < 0.9
    patch = np.flatnonzero(inner & (centroids(bowl)[:, 2] < -0.65))
    bag = mesh_bag(FacetMesh(bowl.points, bowl.triangles, {"in": patch}), inlet="in")
    assert 1.3 < bag.faces < 1.7
    assert "would suck it in" in bag.warnings[0]


def test_rays() -> None:
    triangle = 1.0 * np.array(
        [[[0, 0, 1], [1, 0, 1], [0, 1, 1]], [[0, 0, 3], [1, 0, 3], [0, 1, 3]]], float
    )
    origins = np.array([[0.2, 0.2, 0.0], [0.2, 0.2, 2.0], [0.9, 0.9, 0.0]])
    hits = first_hits(origins, np.tile([0.0, 0.0, 2.0], (3, 1)), triangle)
    assert np.array_equal(hits, [0.5, 0.5, np.inf])


def test_groups_that_are_used(bodies) -> None:
    """A second body, a tether, is left out by naming the membrane."""
    body, _ = bodies.pancake(16)
    other = bodies.icosphere(0)
    n, m = len(body.points), len(body.triangles)
    groups = {**body.groups, "tether": np.arange(m, m + len(other.triangles))}
    both = FacetMesh(np.concatenate([body.points, other.points + 20.0]),
                     np.concatenate([body.triangles, other.triangles + n]), groups)  # fmt: skip
    with pytest.raises(MeshError, match=r"has 2 \(512 triangle.*20 triangle.*geometry.rest"):
        mesh_bag(both, inlet="Inlet")
    bag = mesh_bag(both, inlet="Inlet", rest="membrane")
    assert bag.membrane.n_elements + bag.inlet.n_elements == m
    assert any("left out 20 triangle(s) of 'tether'" in note for note in bag.notes)
    with pytest.raises(
        MeshError, match=r"rest: the mesh has no group 'membran' \(did you mean 'mem"
    ):
        mesh_bag(both, inlet="Inlet", rest=["membran"])


@pytest.mark.parametrize(
    ("inlet", "words"),
    [
        ("inlt", r"no group 'inlt' \(did you mean 'Inlet'\?\); it has 'Inlet', 'membrane'"),
        (
            {"sphere": [0, 0, 9, 1]},
            r"no triangle's centroid lies in the sphere \(0, 0, 9, 1\); ",
        ),
        ({"sphere": [0, 0, 0, -1]}, "radius must be positive"),
        ({"sphere": [0, 0, 0]}, "inlet.sphere: expected 4 finite numbers"),
        ({"plane": [0, 0, 0, 1]}, "normal must not be zero"),
        ({"box": [[0, 0, 0], [1, 1, np.inf]]}, "inlet.box: expected 2 x 3 finite"),
        ({"ring": 1}, "expected a group's name"),
        ({"hole": "here"}, "the mesh is closed"),
        ({"plane": [0, 0, 1, -9]}, "no membrane is left"),
        ({"box": [[-1, -1, -9], [1, 1, 9]]}, r"2 separate patches \(\d+ triangle.*choose one"),
        ({"box": [[3.5, -9, -9], [9, 9, 9]]}, None),
        ({"sphere": [4.26, 1.14, 0.06, 0.05]}, "one element across.*raise mesh.split"),
    ],
)
def test_inlets_refused(bodies, inlet, words: str | None) -> None:
    body, _ = bodies.pancake(16)
    if words is None:
        assert mesh_bag(body, inlet=inlet).inlet.n_elements > 8
        return
    with pytest.raises(MeshError, match=words) as refused:
        mesh_bag(body, inlet=inlet)
    assert "\n" not in str(refused.value)


def test_a_ring_is_no_patch(bodies) -> None:
    body, _ = bodies.pancake(16)
    x = centroids(body)
    ring = np.flatnonzero((x[:, 2] < -0.4) & (abs(np.hypot(x[:, 0], x[:, 1]) - 2.0) < 1.0))
    with pytest.raises(MeshError, match=r"the patch has 2 rims \(.*surrounds other triangles"):
        mesh_bag(FacetMesh(body.points, body.triangles, {"ring": ring}), inlet="ring")


def test_folded_and_unfolded(bodies) -> None:
    body, _ = bodies.pancake(16)

    def fold(x: np.ndarray) -> np.ndarray:
        return np.stack(
            [4 * np.sin(x[:, 0] / 4), x[:, 1], x[:, 2] + 4 - 4 * np.cos(x[:, 0] / 4)], 1
        )

    flat, folded = mesh_bag(body, inlet="Inlet"), mesh_bag(body, inlet="Inlet", fold=fold)
    assert flat.flat is None
    assert np.abs(folded.flat - flat.coefficients).max() < 1e-14
    x, y = (folded.membrane.sample(XI, ETA) @ c[: folded.n_membrane]
            for c in (folded.flat, folded.coefficients))  # fmt: skip
    assert np.abs(fold(x) - y).max() < 2e-3
    assert np.abs((fold(x) - y)[:: XI.size]).max() < 1e-13  # vertices
    given = FacetMesh(fold(body.points), body.triangles, body.groups, reference=body.points)
    read = mesh_bag(given, inlet="Inlet")
    assert np.abs(read.flat - flat.coefficients).max() < 1e-13
    again = mesh_bag(given, inlet="Inlet", fold=lambda x: x + 1.0)  # keeps the reference it has
    assert np.abs(again.flat - read.flat).max() < 1e-13
    assert np.abs(again.coefficients - read.coefficients - 1.0).max() < 1e-12


def test_a_closed_membrane(bodies) -> None:
    bag = mesh_bag(bodies.icosphere(1))
    assert bag.inlet is None
    assert bag.profile is None
    assert bag.rim.membrane.size == 0
    assert bag.support("hinged").shape == (3 * bag.n_membrane, 3 * bag.n_membrane)


def test_sheets_without_distance(bodies) -> None:
    body, _ = bodies.pancake(16)
    flat = FacetMesh(body.points * [1.0, 1.0, 0.0], body.triangles, body.groups)
    with pytest.raises(MeshError, match=r"sheets coincide.*geometry.opening"):
        mesh_bag(flat, inlet="Inlet", smooth=False)


def test_what_faces_what(bodies) -> None:
    """A bag, a flat one that closes towards its rim, and a round one."""
    body, _ = bodies.pancake(24)
    for height, least in ((1.0, 0.9), (0.1, 0.04)):
        flat = FacetMesh(body.points * [1.0, 1.0, height], body.triangles, body.groups)
        assert least < mesh_bag(flat, inlet="Inlet", smooth=False).narrowest < 1.0001 * height
    assert mesh_bag(bodies.icosphere(2)).narrowest == np.inf  # a diameter is three mean distances


def test_a_second_order_mesh_with_a_hole(bodies) -> None:
    """Cap and membrane share second-order edges and the reference."""
    sphere = bodies.raw_sphere(100)
    torn = bodies.without(sphere, centroids(sphere)[:, 2] < -0.8)
    middles = 0.5 * (torn.points[torn.triangles] + torn.points[np.roll(torn.triangles, -1, axis=1)])
    middles /= np.linalg.norm(middles, axis=2, keepdims=True)
    wide = torn.points * [2.0, 1.0, 1.0]
    mesh = FacetMesh(torn.points, torn.triangles, middles=middles, reference=wide)
    bag = mesh_bag(mesh, inlet={"hole": [0, 0, -1]}, degree=2)
    rim = bag.coefficients[bag.n_membrane + bag.inlet.on_edges(bag.rim.inlet)]
    middle = bernstein(2, np.array([0.5])).T @ rim
    assert np.abs(np.linalg.norm(middle, axis=2) - 1.0).max() < 1e-13
    low = bag.flat[bag.n_membrane :][: bag.inlet.n_vertices]
    now = bag.coefficients[bag.n_membrane :][: bag.inlet.n_vertices]
    assert np.abs(low - now * [2.0, 1.0, 1.0]).max() < 1e-12
    assert np.isfinite(bag.profile(now)).all()
