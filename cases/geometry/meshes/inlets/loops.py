"""Loops of edges that have one triangle: the holes of a mesh, and the rim of a patch."""

from __future__ import annotations

import numpy as np

from shells.surfaces.triangles.edge_graph import SIDES, edge_graph

from ..facet_mesh import MeshError


def rim_loops(points: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
    """Vertices along each loop of a mesh's rim, as its triangles run, longest loop first.

    Raises
    ------
    MeshError
        A vertex where loops touch, or edges that no surface has.
    """
    try:
        graph = edge_graph(triangles)
    except ValueError as wrong:
        raise MeshError(f"{wrong}; repair the mesh first") from wrong
    tri, side = graph.triangles[graph.rim, 0], graph.sides[graph.rim, 0]
    ends = triangles[tri[:, None], SIDES[side]]
    start, count = np.unique(ends[:, 0], return_counts=True)
    if count.max(initial=1) > 1:
        at = points[start[int(np.argmax(count))]]
        raise MeshError(
            f"two rims touch in one vertex at {place(at)}: separate them, or add the triangles "
            "between them"
        )
    following = dict(ends.tolist())
    loops = []
    while following:
        first, vertex = next(iter(following.items()))
        loop = [first]
        del following[first]
        while vertex != first:
            loop.append(vertex)
            vertex = following.pop(vertex)
        loops.append(np.array(loop))
    return sorted(loops, key=lambda loop: -length(points[loop]))


def length(loop: np.ndarray) -> float:
    """Length of a closed polygon ``(n, 3)``."""
    return float(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum())


def place(point: np.ndarray) -> str:
    """A point as text."""
    return f"({', '.join(f'{x:.4g}' for x in point)})"


def told(points: np.ndarray, loops: list[np.ndarray], most: int = 4) -> str:
    """Edges, length and centre of loops, as text."""
    one = [
        f"{loop.size} edges, length {length(points[loop]):.4g}, centre "
        f"{place(points[loop].mean(axis=0))}"
        for loop in loops[:most]
    ]
    more = [f"{len(loops) - most} more"] if len(loops) > most else []
    return "; ".join(one + more)
