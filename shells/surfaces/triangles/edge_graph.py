"""Edges of a triangulation: their triangles, their sides, and what no surface can have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SIDES = np.array([[0, 1], [1, 2], [2, 0]])  # vertices of each local edge, counterclockwise
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])  # xi, eta of the vertices


@dataclass(frozen=True)
class EdgeGraph:
    """Edges of triangles.

    Attributes
    ----------
    vertices : (n_edges, 2) int array
        Smaller number first.
    triangles : (n_edges, 2) int array
        The triangle that runs the edge upwards is not always the first; -1 beyond the rim.
    sides : (n_edges, 2) int array
        Local edge within each triangle, ``SIDES``; -1 beyond the rim.
    of_triangle : (n_triangles, 3) int array
        Edge of each side.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    of_triangle: np.ndarray

    @property
    def rim(self) -> np.ndarray:
        """Edges with one triangle, ``(n,)``."""
        return np.flatnonzero(self.triangles[:, 1] < 0)


def edge_graph(triangles: np.ndarray) -> EdgeGraph:
    """The edges of oriented triangles ``(n, 3)``.

    Raises
    ------
    ValueError
        An edge of three or more triangles, or one that both of its triangles run alike.
    """
    ends = triangles[:, SIDES].reshape(-1, 2)
    ordered = np.sort(ends, axis=1)
    vertices, edge, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    if count.max(initial=0) > 2:
        a, b = vertices[int(np.argmax(count))]
        raise ValueError(
            f"edge ({a}, {b}) belongs to {count.max()} triangles: a surface has at most two at an "
            "edge"
        )
    order = np.argsort(edge, kind="stable")
    first = np.searchsorted(edge[order], np.arange(len(vertices)))
    owner = np.full((len(vertices), 2), -1)
    owner[:, 0] = order[first]
    both = count == 2
    owner[both, 1] = order[first[both] + 1]
    alike = ends[owner[both, 0], 0] == ends[owner[both, 1], 0]
    if alike.any():
        a, b = vertices[both][int(np.argmax(alike))]
        raise ValueError(
            f"both triangles at edge ({a}, {b}) run it in one direction: they are oriented apart"
        )
    tri, side = np.divmod(owner, 3)
    alone = owner < 0
    tri[alone] = side[alone] = -1
    return EdgeGraph(vertices, tri, side, edge.reshape(-1, 3))
