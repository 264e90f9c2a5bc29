"""Gauss points of edges: functions of the triangles beside them, frames, kinks.

Frame of the reference at a point of an edge: t along it as its first triangle runs it, and on each
side the conormal in the direction out of the first triangle and into the second, so that
``conormal x t`` is the outward normal of both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...surfaces.local_elements import functions, triangle_exponents
from ...surfaces.splines import unit_gauss
from ...surfaces.triangles.edge_graph import CORNERS, SIDES
from ...surfaces.triangles.triangle_surface import TriangleSurface

SECOND = ((2, 0), (0, 2), (1, 1))


@dataclass(frozen=True)
class Side:
    """One side of some edges: functions at their Gauss points, along parametric directions.

    Attributes
    ----------
    dofs : (n_edges, n_functions) int array
        The edge's own functions first, in the order in which the first triangle runs the edge,
        then those of the two next rows.
    first : (n_edges, n_points, n_functions, 2) array
        Derivatives along the edge and across it; the latter from the first triangle to the second.
    second : (n_edges, n_points, n_functions, 3) array
        Second derivatives along, across and mixed.
    """

    dofs: np.ndarray
    first: np.ndarray
    second: np.ndarray

    def along(self, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivatives of a configuration, ``(n_edges, n_points, 2 or 3, 3)``."""
        local = coefficients[self.dofs]
        first, second = (
            np.einsum("eqad,eac->eqdc", x, local, optimize=True) for x in (self.first, self.second)
        )
        return first, second


def edge_rows(degree: int, side: int, backwards: bool) -> list[np.ndarray]:
    """Local functions of a triangle, row by row from one of its edges, in order along it."""
    a, b = SIDES[side] if not backwards else SIDES[side][::-1]
    exponents = triangle_exponents(degree)
    rows = []
    for k in range(3):
        row = np.flatnonzero(exponents[:, 3 - a - b] == k)
        rows.append(row[np.argsort(exponents[row, b])])
    return rows


def sides_of(surface: TriangleSurface, edges: np.ndarray) -> list[Side]:
    """One side of rim edges, both sides of inner ones, at ``degree + 1`` Gauss points."""
    x, _ = unit_gauss(surface.degree + 1)
    count = 1 if edges.size and surface.graph.triangles[edges[0], 1] < 0 else 2
    return [_side(surface, edges, k, x) for k in range(count)]


def _side(surface: TriangleSurface, edges: np.ndarray, k: int, x: np.ndarray) -> Side:
    p, second = surface.degree, bool(k)
    tables = [_tables(p, side, second, x) for side in range(3)]
    pick = surface.graph.sides[edges, k]
    local, first, hess = (np.array([t[i] for t in tables])[pick] for i in range(3))
    triangle = surface.graph.triangles[edges, k]
    return Side(surface.element_dofs[triangle[:, None], local], first, hess)


def _tables(p: int, side: int, second: bool, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Functions that matter at one side of a triangle, and their derivatives there."""
    a, b = SIDES[side][::-1] if second else SIDES[side]
    points = CORNERS[a] + x[:, None] * (CORNERS[b] - CORNERS[a])
    across = CORNERS[a] - CORNERS[3 - a - b]
    along = np.stack([CORNERS[b] - CORNERS[a], -across if second else across])
    local = np.concatenate(edge_rows(p, side, second))

    def derivative(i: int, j: int) -> np.ndarray:
        return functions("triangle", p, points[:, 0], points[:, 1], (i, j))[:, local]

    first = np.einsum("xqa,dx->qad", np.stack([derivative(1, 0), derivative(0, 1)]), along)
    ss, tt, st = (derivative(*order) for order in SECOND)
    full = np.stack([np.stack([ss, st]), np.stack([st, tt])])
    pairs = ((0, 0), (1, 1), (0, 1))
    hess = [np.einsum("xyqa,x,y->qa", full, along[i], along[j]) for i, j in pairs]
    return local, first, np.stack(hess, axis=-1)


@dataclass(frozen=True)
class Frame:
    """Orthonormal frame of the reference on one side: ``t = length d_along``, and the conormal.

    Attributes
    ----------
    speed : (n_edges, n_points) array
        Length of the edge's derivative: ``ds = speed dx``.
    shift, scale : (n_edges, n_points) array
        The conormal's derivative is ``scale (d_across - shift d_along)``.
    """

    speed: np.ndarray
    shift: np.ndarray
    scale: np.ndarray

    def first(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives along t and the conormal; ``d (n_edges, n_points, ..., 2)``."""
        speed, shift, scale = (_wide(x, d.ndim - 1) for x in (self.speed, self.shift, self.scale))
        return d[..., 0] / speed, scale * (d[..., 1] - shift * d[..., 0])

    def second(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Second derivatives along t and along the conormal; ``d (.., 3)``."""
        speed, shift, scale = (_wide(x, d.ndim - 1) for x in (self.speed, self.shift, self.scale))
        across = d[..., 1] - 2.0 * shift * d[..., 2] + shift**2 * d[..., 0]
        return d[..., 0] / speed**2, scale**2 * across


def _wide(x: np.ndarray, ndim: int) -> np.ndarray:
    return x.reshape(*x.shape, *(1,) * (ndim - x.ndim))


def frame(side: Side, reference: np.ndarray) -> Frame:
    """The frame of a reference ``(n_coefficients, 3)`` on one side of its edges."""
    first, _ = side.along(reference)
    along, across = first[:, :, 0], first[:, :, 1]
    square = np.einsum("eqc,eqc->eq", along, along)
    shift = np.einsum("eqc,eqc->eq", along, across) / square
    scale = 1.0 / np.linalg.norm(across - shift[..., None] * along, axis=-1)
    return Frame(np.sqrt(square), shift, scale)


def conormals(side: Side, coefficients: np.ndarray) -> np.ndarray:
    """Unit conormals of a configuration at the Gauss points, ``(n_edges, n_points, 3)``."""
    first, _ = side.along(coefficients)
    own = frame(side, coefficients)
    return own.first(np.swapaxes(first, -1, -2))[1]


def tangents(side: Side, coefficients: np.ndarray) -> np.ndarray:
    """Unit tangents of edges at the Gauss points, ``(n_edges, n_points, 3)``."""
    along = side.along(coefficients)[0][:, :, 0]
    return along / np.linalg.norm(along, axis=-1, keepdims=True)


def angle(t: np.ndarray, g1: np.ndarray, g2: np.ndarray) -> np.ndarray:
    """Kink about unit tangents t from the half plane of g1 to that of g2, in (-pi, pi]."""
    n1, n2 = np.cross(g1, t), np.cross(g2, t)
    sine = np.einsum("...c,...c->...", np.cross(n1, n2), t)
    return np.arctan2(sine, np.einsum("...c,...c->...", n1, n2))


def kink_angles(surface: TriangleSurface, coefficients: np.ndarray) -> np.ndarray:
    """Kinks between the triangles of a configuration, zero at the rim.

    Parameters
    ----------
    surface : TriangleSurface
    coefficients : (n_coefficients, 3) array

    Returns
    -------
    (n_edges, degree + 1) array
        Angles in radians at the Gauss points of each edge; positive where the normals of the
        triangles spread, as they do on a convex body.
    """
    c = np.asarray(coefficients, dtype=float).reshape(-1, 3)
    inner = np.flatnonzero(surface.graph.triangles[:, 1] >= 0)
    found = np.zeros((len(surface.graph.triangles), surface.degree + 1))
    if inner.size:
        one, two = sides_of(surface, inner)
        found[inner] = angle(tangents(one, c), conormals(one, c), conormals(two, c))
    return found
