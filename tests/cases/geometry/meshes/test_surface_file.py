"""A mesh file as a surface: five lines to a drag, a shell, a bag."""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.surface_file import read_surface


def soup(path, mesh: FacetMesh, scale: float = 1.0) -> str:
    """An ASCII STL, every third triangle flipped."""
    lines = ["solid body"]
    for k, corners in enumerate(scale * mesh.points[mesh.triangles]):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.9e} {y:.9e} {z:.9e}" for x, y, z in corners[:: -1 if k % 3 else 1]]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid body"]))
    return path


def test_drag_of_a_body_in_five_lines(bodies, tmp_path) -> None:
    path = soup(tmp_path / "body.stl", bodies.raw_sphere(100), 1e3)
    from hbem import StokesFlow

    body = read_surface(path, unit="mm")
    flow = StokesFlow(body.patches(), measure="none")
    drag = flow.traction(np.array([0.0, 0.0, 1.0])).force()[0, 2]
    assert abs(abs(drag) / (6.0 * np.pi) - 1.0) < 2e-5  # measured 5e-6; facets 1.9e-2
    assert any("triangles turned" in note for note in body.notes)
    assert body.warnings == ()


def test_a_shell_on_an_open_mesh(bodies, tmp_path) -> None:
    from shells import Material, TriangleShell

    sphere = bodies.icosphere(1)
    half = bodies.without(sphere, sphere.points[sphere.triangles].mean(axis=1)[:, 2] > 0.0)
    body = read_surface(soup(tmp_path / "half.stl", half), degree=2)
    basis = body.basis()
    shell = TriangleShell(basis, Material(1e-3))
    assert shell.energy(body.coefficients) == pytest.approx((0.0, 0.0), abs=1e-20)
    assert basis.dx.sum() == pytest.approx(2.0 * np.pi, rel=0.2)
    with pytest.raises(MeshError, match="the mesh has a hole"):
        body.bag()
    assert body.patches().n_elements == len(half.triangles)


def test_a_bag_in_other_units(bodies, tmp_path) -> None:
    body, volume = bodies.pancake(16)
    path = soup(tmp_path / "bag.stl", body, 1e3)
    surface = read_surface(
        path, unit="mm", length=2.0, inlet={"box": [[-0.5, -0.5, -0.3], [0.5, 0.5, -0.2]]}
    )
    bag, patches = surface.bag(), surface.patches()
    assert bag.exact_volume == pytest.approx(volume / 8.0, rel=1e-3)
    assert patches.n_elements == bag.membrane.n_elements + bag.inlet.n_elements == 512
    assert np.array_equal(patches.coefficients, bag.coefficients)
    assert np.array_equal(surface.coefficients, bag.coefficients[: bag.n_membrane])
    assert "extends over 4.5 x 4.5 x 0.5 L, L = 2000 mm" in bag.notes
    large = read_surface(path)
    assert "9e+03 L large: is geometry.unit missing" in large.warnings[-1]


def test_a_separate_reference(bodies, tmp_path) -> None:
    body, _ = bodies.pancake(16)
    wide = FacetMesh(body.points * [1.5, 1.0, 1.0], body.triangles)
    paths = [soup(tmp_path / f"{name}.stl", mesh) for name, mesh in (("now", body), ("cut", wide))]
    surface = read_surface(paths[0], reference=paths[1], inlet={"plane": [0, 0, -1, 0.49]}, split=1)
    flat, now = surface.mesh.facets.reference, surface.mesh.facets.points
    corners = np.abs(flat - [1.5, 1.0, 1.0] * now).max(axis=1) < 1e-8
    assert corners.sum() >= 258  # those of the file; middles of edges lie on curves
    assert np.array_equal(surface.basis().source, surface.flat)
    other = soup(tmp_path / "other.stl", bodies.icosphere(1))
    with pytest.raises(MeshError, match=r"reference: other.stl has 80 triangles on 240 points"):
        read_surface(paths[0], reference=other)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"unit": "inch"}, "unit = 'inch': expected one of m, dm"),
        ({"unit": "mm", "length": 0.0}, "length = 0.0: expected a positive"),
        ({"split": 2, "most": 1000}, "1280 triangles are more than 1000"),
        ({"inlet": "lid"}, "no group 'lid'"),
    ],
)
def test_refused(bodies, tmp_path, options: dict, words: str) -> None:
    path = soup(tmp_path / "body.stl", bodies.icosphere(1))
    with pytest.raises(MeshError, match=words):
        read_surface(path, **options)
