"""The two sheets of a flat bag of no thickness, told apart by how triangles meet.

Neighbours on opposite sides of their edge lie in one sheet; neighbours on the same side lie on
each other, and their edge is the seam. Edges of four triangles, two on either side, belong to
both sheets: seam vertices joined across the bag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..facet_mesh import FacetMesh, MeshError, place
from ..flat_triangles import plane_areas, plane_cross
from ..mending.topology import edges_of, two_sided
from .plane import PatternPlane, fitted_plane

FLAT = 1e-5  # thickness over size below which sheets coincide
EMPTY = 1e-12  # area over squared size of a triangle whose side of an edge is not known


@dataclass(frozen=True)
class Sheets:
    """Sheets of a flat bag.

    Attributes
    ----------
    plane : PatternPlane
    plan : (n, 2) array
        Points in the plane, unfolded where the mesh has a reference.
    upper : (m,) bool array
        Triangles of the first sheet: the one whose triangles mostly run counterclockwise.
    seam : (k, 2) int array
        Edges where both sheets meet.
    open_edges : (j, 2) int array
        Edges of one triangle.
    """

    plane: PatternPlane
    plan: np.ndarray
    upper: np.ndarray
    seam: np.ndarray
    open_edges: np.ndarray


def told_apart(facets: FacetMesh) -> Sheets:
    """The sheets of a flat bag whose sheets share the points of their seam, and no others.

    Raises
    ------
    MeshError
        A mesh that is not flat, or edges at which sheets cannot be told apart.
    """
    points = unfolded(facets)
    plane = fitted_plane(points)
    if plane.thickness > FLAT * plane.size:
        raise MeshError(
            f"sheets do not coincide: the mesh is {plane.thickness:.3g} thick over "
            f"{plane.size:.3g}; sheets are told apart in flat meshes only"
        )
    plan = plane.coordinates(points)[:, :2]
    area = plane_areas(plan, facets.triangles)
    empty = np.flatnonzero(np.abs(area) <= EMPTY * plane.size**2)
    if empty.size:
        where = place(points[facets.triangles[empty[0]]].mean(axis=0))
        raise MeshError(
            f"{empty.size} triangles of a flat sheet have no area, the first at {where}: "
            "remove them in a mesh tool"
        )
    edges, firsts, sides, turns = _edge_sides(facets.triangles, plan)
    counts = np.diff(firsts)
    two = firsts[:-1][counts == 2]
    s, t = sides[two], sides[two + 1]
    lie_on_each_other = turns[two] == turns[two + 1]
    part, sign = _components(facets.triangles.shape[0], s, t, lie_on_each_other, edges[two], points)
    labels = _join(part, sign, facets.groups, edges, firsts, sides, turns, points)
    if labels @ area < 0.0:
        labels = -labels
    return Sheets(
        plane,
        plan,
        labels > 0,
        edges[two][lie_on_each_other],
        edges[firsts[:-1][counts == 1]],
    )


def unfolded(facets: FacetMesh) -> np.ndarray:
    """Points of the flat bag: the reference where there is one."""
    return facets.points if facets.reference is None else facets.reference


def _edge_sides(
    triangles: np.ndarray, plan: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Edges of triangles, equal ones in a row: edge, first of each, triangle and side it is on."""
    edges = edges_of(triangles)
    order = np.argsort(edges.of.ravel(), kind="stable")
    pairs = edges.ends[edges.of.ravel()[order]]
    opposite = np.roll(triangles, -2, axis=1).ravel()[order]
    start = plan[pairs[:, 0]]
    turns = np.sign(plane_cross(plan[pairs[:, 1]] - start, plan[opposite] - start))
    return pairs, np.concatenate([[0], np.cumsum(edges.counts)]), order // 3, turns


def _components(
    n: int,
    s: np.ndarray,
    t: np.ndarray,
    opposed: np.ndarray,
    edges: np.ndarray,
    points: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Component of each triangle over edges of two triangles, and its sheet there (1 or -1)."""
    one, other = two_sided(n, s, t, opposed)
    twisted = np.flatnonzero(one == other)
    if twisted.size:
        k = np.flatnonzero(one[s] == one[twisted[0]])[0]
        raise MeshError(f"sheets cannot be told apart: both are one {_at(points[edges[k]])}")
    return np.minimum(one, other), np.where(one < other, 1, -1)


def _join(
    part: np.ndarray,
    sign: np.ndarray,
    groups: Mapping[str, np.ndarray],
    edges: np.ndarray,
    firsts: np.ndarray,
    sides: np.ndarray,
    turns: np.ndarray,
    points: np.ndarray,
) -> np.ndarray:
    """Sheet of each triangle, parts joined across edges of four triangles.

    Of the two ways to join them: the one that other edges tell, else the one that keeps more
    groups together; without either, both are the same.
    """
    labels, part = sign.astype(np.int64), part.copy()
    counts = np.diff(firsts)
    for first, count in zip(firsts[:-1][counts > 2], counts[counts > 2], strict=True):
        some, turn = sides[first : first + count], turns[first : first + count]
        left, right = some[turn > 0], some[turn < 0]
        if left.size != 2 or right.size != 2:
            raise MeshError(
                f"{count} triangles meet at one edge, {left.size} and {right.size} on its sides "
                f"{_at(points[edges[first]])}: a flat bag has two sheets, so at most 2 and 2"
            )
        for s, t in (left, right):
            if part[s] != part[t]:
                _merge(part, labels, s, t, same=False)
            elif labels[s] == labels[t]:
                raise MeshError(
                    f"sheets cannot be told apart: one lies on itself {_at(points[edges[first]])}"
                )
        if part[left[0]] != part[right[0]]:
            together = [_shared(groups, left[0], r) + _shared(groups, left[1], o)
                        for r, o in (right, right[::-1])]  # fmt: skip
            _merge(part, labels, left[0], right[int(together[1] > together[0])], same=True)
    return labels


def _merge(part: np.ndarray, labels: np.ndarray, s: int, t: int, *, same: bool) -> None:
    if (labels[s] == labels[t]) != same:
        labels[part == part[t]] *= -1
    part[part == part[t]] = part[s]


def _shared(groups: Mapping[str, np.ndarray], s: int, t: int) -> int:
    return sum(bool(np.isin([s, t], members).all()) for members in groups.values())


def _at(ends: np.ndarray) -> str:
    a, b = (place(end) for end in ends)
    return f"at the edge from {a} to {b}"
