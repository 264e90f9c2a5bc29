"""From facets to Bezier triangles: curved edges from the vertices' normals, then the middles.

The control point next to vertex a of an edge d is ``2 d_a / (3 c (1 + c))`` away, d_a the part of d
in the tangent plane and c the cosine of half the angle between both normals (a third along the axis
of their turn): a circular arc on spheres, a helix on cylinders. The inner one is ``E + k (E - V)``
of the means E of edge points and V of vertices, ``k = 1/2 + 3 sqrt(3) / 16 det(normals)``: spheres
up to fourth order. PN triangles (Vlachos et al. 2001) project d / 3 and have k = 1/2: their rms
distance from a sphere of 796 raw triangles is 3.5e-5, this one's 1.7e-7.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shells.surfaces.local_elements import functions, lattice
from shells.surfaces.triangles.edge_graph import EdgeGraph, edge_graph

from ..facet_mesh import MeshError, place
from ..flat_triangles import unit
from .vertex_normals import VertexFrames, vertex_frames

BULGE = 3.0**1.5 / 16.0  # of equilateral triangles on spheres
STEEP = 0.5  # cosine below which an edge leaves its tangent plane too steeply to be an arc
SHARED = 1e-5  # of an edge: how far its middles of both triangles may lie apart
# functions of the cubic triangle next to the start and the end of each side, and its middle
NEAR_START, NEAR_END, INNER, CORNERS = (1, 7, 5), (3, 8, 2), 4, (0, 6, 9)
SECOND_ORDER = (1, 4, 2)  # functions of the quadratic triangle on each side
SECOND_CORNERS = (0, 3, 5)


def control_points(
    points: np.ndarray,
    triangles: np.ndarray,
    *,
    middles: np.ndarray | None = None,
    degree: int = 3,
    smooth: bool = True,
    crease: float = 30.0,
    surface: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Bezier control points of triangles; neighbours have the same ones on their common edge.

    Parameters
    ----------
    points : (n, 3) array
    triangles : (m, 3) int array
        Oriented.
    middles : (m, 3, 3) array, optional
        Points half way along the sides of second-order triangles, which are taken exactly.
    degree : {2, 3}
        Quadratics go through the middles of the cubics' edges.
    smooth : bool
        Round the edges; False keeps the facets. Second-order triangles stay as they are.
    crease : float
        Degrees: edges whose facets turn by more stay sharp. They are arcs along their curve where
        that turns by less, else straight.
    surface : callable, optional
        Nearest points ``(k, 3)`` of an exact surface: the lattice of each triangle moves there.

    Returns
    -------
    (m, (degree + 1) (degree + 2) / 2, 3) array

    Raises
    ------
    MeshError
        A degree that is not there, an edge of three triangles or of two oriented apart, or
        neighbours whose second-order edges differ.
    """
    if degree not in (2, 3):
        raise MeshError(f"mesh.degree = {degree!r}: triangles of a mesh have degree 2 or 3")
    try:
        graph = edge_graph(triangles)
    except ValueError as wrong:
        raise MeshError(f"{wrong}; repair the mesh first") from wrong
    bulge = np.zeros(len(triangles))
    if middles is not None:
        handles = _second_order(points, middles, graph)
    elif smooth:
        frames = vertex_frames(points, triangles, graph, _radians(crease))
        handles, bulge = _rounded(points, triangles, graph, frames)
    else:
        handles = _chords(points, graph) / 3.0
    control = _assembled(points, triangles, graph, handles, bulge, degree)
    if surface is None:
        return control
    return _projected(control, degree, surface)


def _radians(crease: float) -> float:
    if not 0.0 <= crease <= 180.0:
        raise MeshError(f"geometry.crease = {crease:g}: expected degrees between 0 and 180")
    return float(np.radians(crease))


def _chords(points: np.ndarray, graph: EdgeGraph) -> np.ndarray:
    """Edges ``(n_edges, 2, 3)`` as seen from their lower and their upper vertex."""
    d = np.diff(points[graph.vertices], axis=1)
    return np.concatenate([d, -d], axis=1)


def _upwards(triangles: np.ndarray, graph: EdgeGraph) -> np.ndarray:
    """Whether the first triangle of each edge runs it from the lower vertex, ``(n_edges,)``."""
    return triangles[graph.triangles[:, 0], graph.sides[:, 0]] == graph.vertices[:, 0]


def _rounded(
    points: np.ndarray, triangles: np.ndarray, graph: EdgeGraph, frames: VertexFrames
) -> tuple[np.ndarray, np.ndarray]:
    """Handles ``(n_edges, 2, 3)`` from both ends of each edge, bulges ``(m,)`` of the middles."""
    d = _chords(points, graph)
    tri, side = graph.triangles[:, 0], graph.sides[:, 0]
    # where an edge is smooth, its other triangle has the same normals at both ends
    normals = np.stack([frames.normals[tri, side], frames.normals[tri, (side + 1) % 3]], axis=1)
    down = ~_upwards(triangles, graph)
    normals[down] = normals[down, ::-1]
    across = np.sum(d * normals, axis=2, keepdims=True) * normals
    t = frames.tangents[graph.vertices]
    along = np.sum(d * t, axis=2, keepdims=True) * t
    sharp, curved = (
        np.broadcast_to(kind[:, None], d.shape[:2]) for kind in (frames.sharp, frames.curved)
    )
    # a crease that ends at a vertex does so in its tangent plane; one that turns there is straight
    on_curve = curved & (np.abs(t).sum(axis=2) > 0.0)
    corner = sharp & ~on_curve & (frames.n_sharp[graph.vertices] > 1)
    tangent = np.where(on_curve[..., None], along, np.where(corner[..., None], d, d - across))
    length, reach = np.linalg.norm(d, axis=2), np.linalg.norm(tangent, axis=2)
    cosine = reach / np.where(length > 0.0, length, 1.0)
    # half the angle between the normals; a curve goes by its own tangents
    half = np.sqrt(0.5 + 0.5 * np.sum(normals[:, 0] * normals[:, 1], axis=1))[:, None]
    turn = np.where(on_curve | corner, cosine, half)
    steep = np.minimum(cosine, turn) < STEEP
    turn = np.where(steep, 1.0, turn)
    # along the axis of the turn nothing bends: thirds there keep a rolled sheet unstretched
    axis = np.where(
        (on_curve | corner)[..., None], 0.0, unit(np.cross(*normals.swapaxes(0, 1)))[:, None]
    )
    still = np.sum(tangent * axis, axis=2, keepdims=True) * axis
    arc = still / 3.0 + (tangent - still) * (2.0 / (3.0 * turn * (1.0 + turn)))[..., None]
    bulge = BULGE * np.linalg.det(frames.normals)
    return np.where(steep[..., None], d / 3.0, arc), bulge


def _second_order(points: np.ndarray, middles: np.ndarray, graph: EdgeGraph) -> np.ndarray:
    """Handles of the cubics that are the quadratic edges through ``middles``."""
    middle = middles[graph.triangles, graph.sides]
    alone = graph.triangles[:, 1] < 0
    middle[alone, 1] = middle[alone, 0]
    d = _chords(points, graph)
    apart = np.linalg.norm(middle[:, 1] - middle[:, 0], axis=1)
    wrong = apart > SHARED * np.linalg.norm(d[:, 0], axis=1)
    if wrong.any():
        at = place(middle[int(np.argmax(apart)), 0])
        raise MeshError(
            f"{wrong.sum()} second-order edge(s) have other middles in their two triangles, first "
            f"near {at}: give both the same node, or save the mesh in first order"
        )
    ends = points[graph.vertices]
    control = 2.0 * middle.mean(axis=1) - ends.mean(axis=1)
    return 2.0 / 3.0 * (control[:, None] - ends)


def _assembled(
    points: np.ndarray,
    triangles: np.ndarray,
    graph: EdgeGraph,
    handles: np.ndarray,
    bulge: np.ndarray,
    degree: int,
) -> np.ndarray:
    """Control points of triangles from those of their edges."""
    corners = points[triangles]
    beside = points[graph.vertices] + handles
    upwards = triangles == graph.vertices[graph.of_triangle][..., 0]
    side = beside[graph.of_triangle]  # (m, 3, 2, 3), from the lower vertex
    side = np.where(upwards[..., None, None], side, side[:, :, ::-1])
    control = np.empty((len(triangles), (degree + 1) * (degree + 2) // 2, 3))
    if degree == 2:
        ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
        control[:, SECOND_CORNERS] = corners
        # through the middle of the cubic, (a + 3 p + 3 q + b) / 8
        control[:, SECOND_ORDER] = 0.75 * side.sum(axis=2) - 0.25 * ends.sum(axis=2)
        return control
    control[:, CORNERS] = corners
    control[:, NEAR_START], control[:, NEAR_END] = side[:, :, 0], side[:, :, 1]
    edge, vertex = side.mean(axis=(1, 2)), corners.mean(axis=1)
    control[:, INNER] = edge + (0.5 + bulge)[:, None] * (edge - vertex)
    return control


def _projected(
    control: np.ndarray, degree: int, surface: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Interpolate the nearest points of an exact surface on each triangle's lattice."""
    xi, eta, _ = lattice("triangle", degree)
    table = functions("triangle", degree, xi, eta)
    at = (table @ control).reshape(-1, 3)
    exact = np.asarray(surface(at), dtype=float)
    if exact.shape != at.shape or not np.isfinite(exact).all():
        raise MeshError(
            f"surface: expected finite points {at.shape} for as many, got {exact.shape}"
        )
    return np.linalg.solve(table, exact.reshape(control.shape))
