"""Supports and loads on edges of triangles, which are found by place instead of by parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ..surfaces.local_elements import functions
from ..surfaces.splines import unit_gauss
from ..surfaces.triangles.edge_graph import CORNERS, SIDES
from ..surfaces.triangles.triangle_surface import TriangleSurface
from .edge import Edge
from .supports import Support, vector_dofs


def rim_edges(
    surface: TriangleSurface, coefficients: np.ndarray, where: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Rim edges whose control points all lie where a condition holds.

    Parameters
    ----------
    surface : TriangleSurface
    coefficients : (n_coefficients, 3) array
    where : callable
        Takes points ``(..., 3)`` and returns booleans ``(...)``.

    Returns
    -------
    (n,) int array
        Numbers of edges.

    Raises
    ------
    ValueError
        If there is none.
    """
    rim = surface.graph.rim
    found = rim[np.asarray(where(coefficients[surface.on_edges(rim)])).all(axis=1)]
    if not found.size:
        raise ValueError(f"none of {rim.size} rim edges lies where the condition holds")
    return found


def hold_edges(
    surface: TriangleSurface, edges: np.ndarray, components: Iterable[int] = (0, 1, 2)
) -> Support:
    """Hold some components of edges; slopes stay free (see `TriangleShell`, clamp).

    Parameters
    ----------
    surface : TriangleSurface
    edges : (n,) int array
        Numbers of edges.
    components : ints
        Cartesian components that are held.

    Returns
    -------
    Support
        For `shells.supported`.
    """
    return Support(vector_dofs(np.unique(surface.on_edges(edges)), components))


def triangle_edge(surface: TriangleSurface, edges: np.ndarray, reference: np.ndarray) -> Edge:
    """Rim edges with Gauss points: loads and moments along them.

    Parameters
    ----------
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.
    """
    x, w = unit_gauss(surface.degree + 1)
    tables = [_tables(surface.degree, side, x) for side in range(3)]
    triangle, side = surface.graph.triangles[edges, 0], surface.graph.sides[edges, 0]
    local = np.array(tables)[side]  # (edge, kind, point, function)
    columns = np.broadcast_to(surface.element_dofs[triangle][:, None], local[:, 0].shape)
    starts = np.arange(columns.size // columns.shape[2] + 1) * columns.shape[2]

    def table(kind: int) -> csr_matrix:
        shape = (starts.size - 1, surface.n_coefficients)
        return csr_matrix((local[:, kind].ravel(), columns.ravel(), starts), shape)

    value, across, along = (table(kind) for kind in range(3))
    length = np.linalg.norm(along @ reference, axis=1)
    return Edge(value, across, along, np.tile(w, edges.size) * length)


def _tables(degree: int, side: int, x: np.ndarray) -> np.ndarray:
    """Functions on a side, their derivatives out of the triangle and along the side."""
    a, b = SIDES[side]
    points = CORNERS[a] + x[:, None] * (CORNERS[b] - CORNERS[a])
    value, by_xi, by_eta = (
        functions("triangle", degree, points[:, 0], points[:, 1], order)
        for order in ((0, 0), (1, 0), (0, 1))
    )
    out, along = CORNERS[a] - CORNERS[3 - a - b], CORNERS[b] - CORNERS[a]
    return np.stack([value, *(d[0] * by_xi + d[1] * by_eta for d in (out, along))])


def edge_load(
    surface: TriangleSurface, edges: np.ndarray, force: ArrayLike, reference: np.ndarray
) -> np.ndarray:
    """Dead load of a force per reference length along edges.

    Parameters
    ----------
    surface : TriangleSurface
    edges : (n,) int array
        Numbers of edges.
    force : (3,) array
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.

    Returns
    -------
    (n_coefficients, 3) array
    """
    return triangle_edge(surface, edges, reference).line_load(np.asarray(force, dtype=float))
