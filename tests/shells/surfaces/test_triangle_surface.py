"""Bezier triangles on a triangulation: numbering, sharing, and what is refused."""

import numpy as np
import pytest

from shells.surfaces.local_elements import lattice
from shells.surfaces.triangles.triangle_surface import TriangleSurface

TWO = np.array([[0, 1, 2], [2, 1, 3]])
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_neighbours_share_their_edge(degree: int) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.0, 1.0, 0.1], [1.0, 1.0, 0.5]])
    surface = TriangleSurface(TWO, degree)
    xi, eta, _ = lattice("triangle", degree)
    flat = np.einsum(
        "kn,enc->ekc", np.stack([1 - xi - eta, xi, eta], axis=1), points[TWO]
    )  # of flat triangles, bent along x by a polynomial of the degree
    bent = flat + 0.1 * flat[..., :1] ** degree * np.array([0.0, 0.0, 1.0])
    c = surface.coefficients_of(surface.interpolation(bent))
    assert np.allclose(surface.sample(xi, eta) @ c, bent.reshape(-1, 3), atol=1e-14)
    inner = (degree - 1) * (degree - 2) // 2
    assert surface.n_coefficients == 4 + 5 * (degree - 1) + 2 * inner
    assert surface.rim_coefficients.size == 4 + 4 * (degree - 1)
    along = surface.on_edges(surface.graph.rim)
    assert np.array_equal(np.unique(along), surface.rim_coefficients)


def test_closed() -> None:
    surface = TriangleSurface(TETRAHEDRON, 3, density=2)
    assert surface.open_edges == {}
    assert surface.n_coefficients == 4 + 2 * 6 + 4
    assert surface.n_dofs == 4 + 6
    xi, eta, _ = lattice("triangle", 2)
    assert np.allclose(surface.sample_density(xi, eta) @ np.ones(10), 1.0)


@pytest.mark.parametrize(
    ("triangles", "words"),
    [
        ([[0, 1, 2], [1, 2, 3]], "oriented apart"),
        ([[0, 1, 2], [2, 1, 3], [1, 2, 4]], "3 triangles"),
        ([[0, 1, 3]], "each used"),
        ([[0, 1, 2, 3]], "expected triangles"),
    ],
)
def test_refused(triangles: list, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        TriangleSurface(np.array(triangles)).graph  # noqa: B018
