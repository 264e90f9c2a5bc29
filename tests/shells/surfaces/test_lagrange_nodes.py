"""Nodes of Lagrange triangles: the order that VTK prescribes, and flat pieces that tile."""

import numpy as np
import pytest

from shells.surfaces.local_elements import lattice, triangle_exponents
from shells.surfaces.triangles.lagrange_nodes import flat_cells, lagrange_order


def test_cubic_order() -> None:
    """Vertices, two nodes along each edge as it runs, the middle."""
    nodes = triangle_exponents(3)[lagrange_order(3)]
    expected = [
        [3, 0, 0], [0, 3, 0], [0, 0, 3], [2, 1, 0], [1, 2, 0], [0, 2, 1], [0, 1, 2], [1, 0, 2],
        [2, 0, 1], [1, 1, 1],
    ]  # fmt: skip
    assert nodes.tolist() == expected


@pytest.mark.parametrize("order", [1, 2, 3, 4, 7])
def test_pieces_tile(order: int) -> None:
    xi, eta, _ = lattice("triangle", order)
    nodes = lagrange_order(order)
    assert sorted(nodes) == list(range(nodes.size))
    x, y = (v[nodes][flat_cells(nodes.size)] for v in (xi, eta))
    twice = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    assert np.allclose(twice, 1.0 / order**2)
