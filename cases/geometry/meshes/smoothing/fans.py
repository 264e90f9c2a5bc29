"""Fans of triangles around vertices, that smooth edges join, and their normals.

With ``q = e / |e|^2`` of its edges e from the vertex (an inversion that makes a sphere through the
vertex a plane) a closed fan's normal is the area vector of the polygon of the q, ``sum q_i x
q_(i+1)``: exact on spheres (Max 1999). Flat regions lend theirs to the fans where they end, so
that sheets stay flat beside round rims. A fan that ends at a sharp curve is steered by the normals
of its inner neighbours: on an arc the tangent at one end is that at the other one, reflected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from shells.surfaces.triangles.edge_graph import EdgeGraph

from ..flat_triangles import unit

SWEEPS = 2  # the first brings most: errors on raw ellipsoids halve
SPREAD = 0.05  # of a plane's two directions, below which edges do not span it


@dataclass(frozen=True)
class Fans:
    """Fans of all vertices.

    Attributes
    ----------
    of_corner : (m, 3) int array
        Fan of each corner of each triangle.
    open : (n_fans,) bool array
        Fans that sharp edges bound.
    """

    of_corner: np.ndarray
    open: np.ndarray


def inverted(edges: np.ndarray) -> np.ndarray:
    """Vectors ``(..., 3)`` over the squares of their lengths."""
    square = np.sum(edges**2, axis=-1, keepdims=True)
    return edges / np.where(square > 0.0, square, 1.0)


def fans_between(triangles: np.ndarray, graph: EdgeGraph, sharp: np.ndarray) -> Fans:
    """Corners joined across the edges that are not sharp ``(n_edges,)``."""
    tri, side = graph.triangles[~sharp], graph.sides[~sharp]
    start, end = 3 * tri + side, 3 * tri + (side + 1) % 3
    # the second triangle runs the edge backwards
    rows = np.concatenate([start[:, 0], end[:, 0]])
    columns = np.concatenate([end[:, 1], start[:, 1]])
    n = triangles.size
    joined = coo_matrix((np.ones(rows.size), (rows, columns)), shape=(n, n))
    count, fan = connected_components(joined, directed=False)
    fan = fan.reshape(-1, 3)
    opened = np.zeros(count, dtype=bool)
    bounds = sharp[graph.of_triangle]
    opened[fan[bounds]] = True
    opened[np.roll(fan, -1, axis=1)[bounds]] = True
    return Fans(fan, opened)


def fan_normals(
    points: np.ndarray, triangles: np.ndarray, fans: Fans, flat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals ``(n_fans, 3)``, and which are those of flat triangles ``(m,)`` alone."""
    corner, fan = points[triangles], fans.of_corner
    q_next = inverted(np.roll(corner, -1, axis=1) - corner)
    q_last = inverted(np.roll(corner, -2, axis=1) - corner)
    area, level = np.zeros((2, fans.open.size, 3))
    part = np.cross(q_next, q_last)
    np.add.at(area, fan, part)
    np.add.at(level, fan[flat], part[flat])
    is_flat: np.ndarray = np.any(level != 0.0, axis=1)
    return unit(np.where(is_flat[:, None], level, area)), is_flat


class _Reach:
    """Edges seen from both ends: the fan here, the one at the other end, and the way there."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, graph: EdgeGraph, fans: Fans):
        both = graph.triangles[:, 1] >= 0
        tri, side = graph.triangles[both, 0], graph.sides[both, 0]
        ends = np.stack([side, (side + 1) % 3], axis=1)
        ends, tri = np.concatenate([ends, ends[:, ::-1]]), np.concatenate([tri, tri])
        self.here, self.there = fans.of_corner[tri[:, None], ends].T
        self.way = unit(np.diff(points[triangles[tri[:, None], ends]], axis=1)[:, 0])

    def of(self, used: np.ndarray) -> _Reach:
        """Some of them."""
        part = object.__new__(_Reach)
        part.here, part.there, part.way = self.here[used], self.there[used], self.way[used]
        return part

    def leaving(self, normals: np.ndarray) -> np.ndarray:
        """Unit tangents here of arcs that arrive there in the tangent plane."""
        arriving = _in_plane(self.way, normals[self.there])
        return 2.0 * np.sum(self.way * arriving, axis=1, keepdims=True) * self.way - arriving


def _in_plane(way: np.ndarray, normals: np.ndarray) -> np.ndarray:
    return unit(way - np.sum(way * normals, axis=1, keepdims=True) * normals)


def balanced(
    points: np.ndarray,
    triangles: np.ndarray,
    graph: EdgeGraph,
    fans: Fans,
    normals: np.ndarray,
    fixed: np.ndarray,
) -> np.ndarray:
    """Normals ``(n_fans, 3)`` that make edges as steep at one end as at the other, where they can.

    A plane least off the tangents half way between its own and those of arcs from its neighbours:
    where long edges meet short ones a normal alone would bulge the long ones.
    """
    reach = _Reach(points, triangles, graph, fans)
    free = ~fixed & ~fans.open
    reach = reach.of(free[reach.here] & ~fans.open[reach.there])
    for _ in range(SWEEPS):
        own = _in_plane(reach.way, normals[reach.here])
        wanted = unit(own + reach.leaving(normals))
        spread = np.zeros((len(normals), 3, 3))
        np.add.at(spread, reach.here, wanted[:, :, None] * wanted[:, None, :])
        values, axes = np.linalg.eigh(spread)
        found = axes[:, :, 0]
        found *= np.sign(np.sum(found * normals, axis=1, keepdims=True))
        done = free & (values[:, 1] > SPREAD * values[:, 2]) & (values[:, 2] > 0.0)
        normals = np.where(done[:, None], found, normals)
    return normals


def steered(
    points: np.ndarray,
    triangles: np.ndarray,
    graph: EdgeGraph,
    fans: Fans,
    normals: np.ndarray,
    along: np.ndarray,
    steer: np.ndarray,
) -> np.ndarray:
    """Normals ``(n_fans, 3)`` of fans beside smooth sharp curves, from those of inner neighbours.

    Parameters
    ----------
    points, triangles, graph, fans :
        The mesh.
    normals : (n_fans, 3) array
        Of all fans.
    along : (n_fans, 3) array
        Unit tangent of the curve at each fan; zero where there is none.
    steer : (n_fans,) bool array
        Fans to be steered.
    """
    reach = _Reach(points, triangles, graph, fans)
    reach = reach.of(steer[reach.here] & ~fans.open[reach.there])
    inward = np.zeros_like(normals)
    np.add.at(inward, reach.here, reach.leaving(normals))
    found = np.cross(along, inward)
    found *= np.sign(np.sum(found * normals, axis=1, keepdims=True))
    done = np.linalg.norm(found, axis=1) > 1e-3
    return np.where(done[:, None], unit(found), normals)
