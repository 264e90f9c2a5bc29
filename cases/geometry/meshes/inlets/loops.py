"""Holes of a mesh and rims of its patches, in words, and as one surface has them."""

from __future__ import annotations

import numpy as np

from shells.surfaces.triangles.edge_graph import edge_graph

from ..facet_mesh import MeshError, place
from ..figures import Hole, holes


def rims(points: np.ndarray, triangles: np.ndarray) -> list[Hole]:
    """Loops of edges with one triangle, the longest first.

    Raises
    ------
    MeshError
        A vertex where rims touch, or edges that no surface has.
    """
    try:
        edge_graph(triangles)
    except ValueError as wrong:
        raise MeshError(f"{wrong}; repair the mesh first") from wrong
    found = holes(points, triangles)
    vertices = np.concatenate([np.empty(0, dtype=int), *(hole.loop for hole in found)])
    vertex, count = np.unique(vertices, return_counts=True)
    if count.max(initial=1) > 1:
        raise MeshError(
            f"rims touch in one vertex at {place(points[vertex[int(np.argmax(count))]])}: add the "
            "triangles between them, or take some away"
        )
    return found


def told(found: list[Hole], most: int = 4) -> str:
    """Edges, length and centre of each."""
    one = [
        f"{hole.loop.size} edges, length {hole.length:.4g}, centre {place(hole.centre)}"
        for hole in found[:most]
    ]
    return "; ".join(one + ([f"{len(found) - most} more"] if len(found) > most else []))
