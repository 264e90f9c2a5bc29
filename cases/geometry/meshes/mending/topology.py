"""Edges, fans, sheets and rims of triangles: what joins what, by vertex numbers alone.

Of any triangles, however they meet, before and while they are mended; `edge_graph` of shells is
of what they must have become: an oriented surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FacetEdges:
    """Edges of triangles (m, 3); side k of a triangle runs from its corner k to k + 1.

    Attributes
    ----------
    ends : (n, 2) int array
        Vertices, smaller first.
    of : (m, 3) int array
        Edge of each side.
    counts : (n,) int array
        Triangles at each edge.
    forward : (m, 3) bool array
        Whether the side runs from the smaller vertex to the larger one.
    """

    ends: np.ndarray
    of: np.ndarray
    counts: np.ndarray
    forward: np.ndarray

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Sides (3 t + k) that share an edge of two triangles, one of each pair."""
        order = np.argsort(self.of.ravel(), kind="stable")
        starts = np.cumsum(self.counts) - self.counts
        first = starts[self.counts == 2]
        return order[first], order[first + 1]


def edges_of(triangles: np.ndarray) -> FacetEdges:
    """Edges in the order of their vertices."""
    starts, stops = triangles, np.roll(triangles, -1, axis=1)
    low, high = np.minimum(starts, stops).ravel(), np.maximum(starts, stops).ravel()
    span = int(triangles.max()) + 1 if triangles.size else 1
    keys, inverse, counts = np.unique(low * span + high, return_inverse=True, return_counts=True)
    ends = np.stack([keys // span, keys % span], axis=1)
    return FacetEdges(ends, inverse.reshape(triangles.shape), counts, starts < stops)


def joined(count: int, a: np.ndarray, b: np.ndarray) -> tuple[int, np.ndarray]:
    """Number of connected parts among `count` nodes with the links a - b, and each node's part."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(a), np.int8), (a, b)), (count, count))
    number, parts = connected_components(links, directed=False)
    return int(number), parts


def two_sided(
    count: int, a: np.ndarray, b: np.ndarray, opposed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles put on one of two sides each, so that linked ones agree or are opposed.

    Each is two nodes of a graph, one for either side; a link joins equal or opposed ones. Both
    nodes in one part: the links contradict each other.

    Parameters
    ----------
    count : int
        Number of triangles.
    a, b : (k,) int array
        Linked triangles.
    opposed : (k,) bool array
        Which links want opposite sides.

    Returns
    -------
    (count,) int array, (count,) int array
        Part of each triangle's first and of its second node.
    """
    first = np.concatenate([a, a + count])
    second = np.concatenate([np.where(opposed, b + count, b), np.where(opposed, b, b + count)])
    _, found = joined(2 * count, first, second)
    return found[:count], found[count:]


def sheets(triangles: np.ndarray, edges: FacetEdges | None = None) -> tuple[int, np.ndarray]:
    """Parts that hang together by edges, and the part of each triangle."""
    first, second = (edges or edges_of(triangles)).pairs()
    return joined(len(triangles), first // 3, second // 3)


def fans(triangles: np.ndarray, edges: FacetEdges) -> np.ndarray:
    """Corners (m, 3) numbered so that those are equal which hang together by edges."""
    first, second = edges.pairs()
    after = 3 * (np.arange(triangles.size) // 3) + (np.arange(triangles.size) + 1) % 3
    corners = triangles.ravel()
    a, b = np.concatenate([first, after[first]]), np.concatenate([second, after[second]])
    # the same vertex stands at the same end of the other side, or at its other end
    other = np.concatenate([after[second], second])
    b = np.where(corners[a] == corners[b], b, other)
    return joined(triangles.size, a, b)[1].reshape(triangles.shape)


def boundary_loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Closed rows of vertices along the rim, in the direction of the triangles' sides.

    Parameters
    ----------
    triangles : (m, 3) int array
        Oriented alike, at most two at an edge. Rims that touch in a vertex stay apart.

    Returns
    -------
    list of (k,) int array
        Longest first (by number of vertices).
    """
    edges = edges_of(triangles)
    across = np.full(triangles.size, -1)
    first, second = edges.pairs()
    across[first], across[second] = second, first
    corners = triangles.ravel()
    rim = np.flatnonzero(edges.counts[edges.of.ravel()] == 1)
    left, loops = dict.fromkeys(rim.tolist()), []
    while left:
        side, loop = next(iter(left)), []
        while side in left:
            del left[side]
            loop.append(int(corners[side]))
            side = _after(side)
            while across[side] >= 0:
                side = _after(int(across[side]))
        loops.append(np.array(loop))
    return sorted(loops, key=len, reverse=True)


def _after(side: int) -> int:
    """Next side of the same triangle."""
    return side - side % 3 + (side + 1) % 3
