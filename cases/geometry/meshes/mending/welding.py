"""Points of triangles that are one: near each other, and free to be joined.

A file that joins its triangles by point numbers is believed: only points on its rims are welded,
so that two sheets that lie on each other stay two. A soup is all rim, so all of it is welded.
"""

from __future__ import annotations

import numpy as np

from ..facet_mesh import MeshError
from .topology import edges_of, joined

# Pairs of near points per point: beyond, the distance joins much more than copies.
MOST_PAIRS = 60


def welded(points: np.ndarray, triangles: np.ndarray, distance: float) -> np.ndarray:
    """First of the points that each is one with, (n,).

    Raises
    ------
    MeshError
        Where the distance takes in much more than the copies of a point.
    """
    edges = edges_of(triangles)
    free = np.zeros(len(points), bool)
    free[edges.ends[edges.counts == 1]] = True
    lengths = np.linalg.norm(np.diff(points[edges.ends], axis=1)[:, 0], axis=1)
    short = edges.ends[lengths <= distance]
    own = np.flatnonzero(free)
    a, b = _near(points[own], distance)
    return first_of(len(points), np.append(own[a], short[:, 0]), np.append(own[b], short[:, 1]))


def first_of(count: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """First node of each node's part among the links a - b."""
    number, parts = joined(count, a, b)
    first = np.full(number, count)
    np.minimum.at(first, parts, np.arange(count))
    return first[parts]


def _near(points: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs within the distance that link all points which are one."""
    from scipy.spatial import cKDTree

    if not len(points):
        return np.empty(0, int), np.empty(0, int)
    # copies to the last bit first: a thousand of one point would be half a million pairs
    order = np.lexsort(points.T)
    ranked = points[order]
    new = np.append(True, np.any(ranked[1:] != ranked[:-1], axis=1))
    first = order[new][np.cumsum(new) - 1]
    single = order[new]
    tree = cKDTree(points[single])
    if tree.count_neighbors(tree, distance) > MOST_PAIRS * len(single):
        raise MeshError(
            f"a weld distance of {distance:.3g} joins dozens of points into one; use a smaller "
            "weld (geometry.weld)"
        )
    pairs = tree.query_pairs(distance, output_type="ndarray")
    return (
        np.concatenate([order, single[pairs[:, 0]]]),
        np.concatenate([first, single[pairs[:, 1]]]),
    )
