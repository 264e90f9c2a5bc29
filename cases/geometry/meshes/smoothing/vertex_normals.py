"""What is smooth at the vertices: normals at the corners of triangles, tangents of their curves.

Curves are sharp edges, and edges along which flat regions go over into bent ones: normals alone
would leave the outline of a round sheet a polygon. A tangent is that of the circle through a
vertex and its two neighbours, or of the straight line that ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shells.surfaces.triangles.edge_graph import EdgeGraph

from ..flat_triangles import angles_between, facet_normals, unit
from .fans import balanced, fan_normals, fans_between, inverted, steered

SAME_ANGLE = 1e-8  # radians that rounding may add to an angle given by the user
FLAT = 5e-4  # radians up to which facets are one plane, and edges one line


@dataclass(frozen=True)
class VertexFrames:
    """What is smooth at the vertices.

    Attributes
    ----------
    sharp : (n_edges,) bool array
        Creases, and edges with one triangle.
    curved : (n_edges,) bool array
        Those, and the outlines of flat regions.
    normals : (m, 3, 3) array
        Unit normal at each corner of each triangle, that of its fan.
    tangents : (n, 3) array
        Unit tangent of the curve through a vertex; zero where none runs through smoothly.
    n_sharp : (n,) int array
        Sharp edges at each vertex.
    """

    sharp: np.ndarray
    curved: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray
    n_sharp: np.ndarray


def turns(points: np.ndarray, triangles: np.ndarray, graph: EdgeGraph) -> np.ndarray:
    """Angles ``(n_edges,)`` between the normals of both triangles; infinite with one triangle."""
    n1, n2 = facet_normals(points, triangles)[graph.triangles].transpose(1, 0, 2)
    return np.where(graph.triangles[:, 1] < 0, np.inf, angles_between(n1, n2))


def vertex_frames(
    points: np.ndarray, triangles: np.ndarray, graph: EdgeGraph, crease: float
) -> VertexFrames:
    """Normals of fans and tangents of sharp curves; ``crease`` in radians."""
    angle = turns(points, triangles, graph)
    sharp = angle > crease + SAME_ANGLE
    flat = _flat(triangles, graph, angle)
    outline = (flat[graph.triangles[:, 0]] != flat[graph.triangles[:, 1]]) & (angle > FLAT)
    curved = sharp | outline
    n_sharp, n_curved = (
        np.bincount(graph.vertices[kind].ravel(), minlength=len(points)) for kind in (sharp, curved)
    )
    tangents = _tangents(points, graph.vertices[curved], n_curved, crease)
    fans = fans_between(triangles, graph, sharp)
    normals, level = fan_normals(points, triangles, fans, flat)
    normals = balanced(points, triangles, graph, fans, normals, level)
    along = np.zeros_like(normals)
    along[fans.of_corner] = tangents[triangles]
    steer = fans.open & ~level & along.any(axis=1)
    normals = steered(points, triangles, graph, fans, normals, along, steer)
    normals = unit(normals - np.sum(normals * along, axis=1, keepdims=True) * along)
    return VertexFrames(sharp, curved, normals[fans.of_corner], tangents, n_sharp)


def _flat(triangles: np.ndarray, graph: EdgeGraph, angle: np.ndarray) -> np.ndarray:
    """Triangles ``(m,)`` of flat regions: those with a vertex where all edges are flat.

    Strips of a cylinder are flat, too, but have no such vertex.
    """
    bent = np.zeros(triangles.max() + 1, dtype=bool)
    bent[graph.vertices[angle > FLAT]] = True
    return ~bent[triangles].all(axis=1)


def _tangents(points: np.ndarray, ends: np.ndarray, count: np.ndarray, crease: float) -> np.ndarray:
    """Tangents where exactly two edges of a curve meet and turn by no more than a crease."""
    vertex, other = ends.ravel(), ends[:, ::-1].ravel()
    order = np.argsort(vertex, kind="stable")
    order = order[count[vertex[order]] == 2]
    v, pair = vertex[order[::2]], other[order].reshape(-1, 2)
    back, on = (points[v] - points[pair[:, 0]]), (points[pair[:, 1]] - points[v])
    turn = angles_between(back, on)
    straight = np.zeros(len(points), dtype=bool)
    straight[v[turn <= FLAT]] = True
    one = straight[pair[:, 0]] != straight[pair[:, 1]]
    line = np.where(straight[pair[:, :1]], back, on)
    tangent = np.where(one[:, None], line, inverted(on) + inverted(back))
    tangents = np.zeros_like(points)
    smooth = turn <= crease + SAME_ANGLE
    tangents[v[smooth]] = unit(tangent[smooth])
    return tangents
