"""Welding of a whole mesh, with what it brings: chords, collapsed and doubled triangles.

Two sheets joined along their rims only may each have an edge between the same two rim points; as
one edge these would have four triangles, so that each sheet gets a point of its own there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..facet_mesh import MeshError, place
from .bisection import bisected
from .doubles import drop_doubles
from .state import Mending
from .topology import FacetEdges, edges_of
from .welding import first_of, welded

# Sheets that share more are no sheets.
MOST_CHORDS = 2000


def weld(mesh: Mending) -> None:
    """Join points; the sheets of a soup that lie on each other by their groups."""
    points, triangles = mesh.mesh.points, mesh.mesh.triangles
    count = _used(triangles)
    soup = count == triangles.size
    one = welded(points, triangles, mesh.distance)
    drop_doubles(mesh, one[triangles] if soup else triangles)
    triangles = mesh.mesh.triangles
    corners = one[triangles]
    if soup and np.any(edges_of(corners[_proper(corners)]).counts > 2):
        one = _sheet_by_sheet(mesh, one)
    left = _used(one[mesh.mesh.triangles])
    one = _chords(mesh, one)
    _check_reference(mesh, one)
    triangles = one[mesh.mesh.triangles]
    if left < count:
        mesh.notes.append(f"{len(mesh.given.triangles)} triangles, {count} points welded to {left}")
    unused = len(mesh.given.points) - count
    if unused:
        mesh.notes.append(f"{unused} points that no triangle uses left out")
    mesh.number(triangles)
    proper = _proper(triangles)
    if not np.all(proper):
        where = place(mesh.mesh.points[triangles[np.argmin(proper)]].mean(axis=0))
        mesh.notes.append(f"{np.sum(~proper)} collapsed triangles dropped, the first at {where}")
        mesh.take(proper)
    if not len(mesh.mesh.triangles):
        raise MeshError("all of its triangles are collapsed to lines or points; export it again")
    drop_doubles(mesh, mesh.mesh.triangles)
    edges = edges_of(mesh.mesh.triangles)
    shortest = _lengths(mesh.mesh.points, edges.ends).min()
    if shortest < 10 * mesh.distance:
        mesh.notes.append(
            f"warning: the shortest edge, {shortest:.3g}, is less than ten weld distances of "
            f"{mesh.distance:.3g}; points may be welded that are not one: lower geometry.weld"
        )


def _used(triangles: np.ndarray) -> int:
    """Number of vertices that triangles use."""
    return int(np.count_nonzero(np.bincount(triangles.ravel())))


def _proper(triangles: np.ndarray) -> np.ndarray:
    """Triangles ``(m,) bool`` of three vertices."""
    return np.all(triangles != np.roll(triangles, -1, axis=1), axis=1)


def _lengths(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)


def _sheet_by_sheet(mesh: Mending, one: np.ndarray) -> np.ndarray:
    """Weld each group of a soup alone, then their rims to each other, where that gives sheets."""
    points, triangles = mesh.mesh.points, mesh.mesh.triangles
    if len(mesh.given.groups) < 2:
        return one
    inner = np.arange(len(points))
    for own in mesh.given.groups.values():
        found = welded(points, triangles[np.isin(mesh.origin, own)], mesh.distance)
        moved = np.flatnonzero(found != np.arange(len(points)))
        inner[moved] = found[moved]
    inner = first_of(len(points), np.arange(len(points)), inner)
    outer = welded(points, inner[triangles], mesh.distance)
    if np.any(_crowded(inner[triangles], outer)):
        return one
    mesh.notes.append("sheets that lie on each other told apart by their groups")
    mesh.number(inner[triangles])
    return outer


@dataclass(frozen=True)
class _Meeting:
    """Edges before welding: which meet others after it, and whether rims are among these."""

    edges: FacetEdges
    total: np.ndarray  # triangles at the welded edge
    inner: np.ndarray  # whether all that meet there had two triangles

    @classmethod
    def of(cls, triangles: np.ndarray, one: np.ndarray) -> _Meeting:
        edges = edges_of(triangles)
        ends = np.sort(one[edges.ends], axis=1)
        keys = ends @ np.array([int(one.max()) + 1, 1])
        _, inverse = np.unique(keys, return_inverse=True)
        real = ends[:, 0] != ends[:, 1]
        total = np.where(real, np.bincount(inverse, edges.counts)[inverse], 0).astype(int)
        return cls(edges, total, (np.bincount(inverse, edges.counts != 2) == 0)[inverse])


def _crowded(triangles: np.ndarray, one: np.ndarray) -> np.ndarray:
    """Edges of more than two triangles after welding that are no chords of sheets."""
    meeting = _Meeting.of(triangles, one)
    return (meeting.total > 2) & ~meeting.inner


def _chords(mesh: Mending, one: np.ndarray) -> np.ndarray:
    """Halve the edges across each sheet whose ends are welded to those of another's."""
    meeting = _Meeting.of(mesh.mesh.triangles, one)
    chords = meeting.inner & (meeting.total > 2)
    number = int(np.sum(chords))
    if not number or number > MOST_CHORDS:
        return one
    mesh.mesh, parents = bisected(mesh.mesh, chords[meeting.edges.of])
    mesh.origin = mesh.origin[parents]
    mesh.notes.append(
        f"{number} edges halved that join the same two points of a rim across both of its sheets"
    )
    return np.concatenate([one, np.arange(len(one), len(mesh.mesh.points))])


def _check_reference(mesh: Mending, one: np.ndarray) -> None:
    reference = mesh.mesh.reference
    if reference is None:
        return
    apart = np.linalg.norm(reference - reference[one], axis=1)
    worst = int(np.argmax(apart))
    if apart[worst] > 10 * mesh.distance:
        raise MeshError(
            f"points welded at {place(mesh.mesh.points[worst])} lie {apart[worst]:.3g} apart in "
            "the reference geometry: give seams points that both sides share"
        )
