"""Triangles without height: the long edge is given to its neighbour's other diagonal.

A corner c on the edge a b of its own triangle (CAD files are full of them) splits the neighbour
(b, a, d) in two, (c, a, d) and (d, b, c): the surface stays where it was. On a rim it is dropped.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import MeshError, place
from ..flat_triangles import facet_areas
from .state import Mending

# Needles beside needles are turned one after the other; files with more are no surfaces.
MOST_NEEDLES = 2000
REMEDY = "remesh there, or lower geometry.weld"


def turn_needles(mesh: Mending) -> None:
    """Turn or drop the triangles lower than the weld distance; they must be oriented alike.

    Raises
    ------
    MeshError
        One that cannot be turned, or too many.
    """
    points, height = mesh.mesh.points, max(mesh.distance, 1e-13 * mesh.size)
    needles = np.flatnonzero(_heights(points, mesh.mesh.triangles) <= height)
    if not len(needles):
        return
    first = place(points[mesh.mesh.triangles[needles[0]]].mean(axis=0))
    if len(needles) > MOST_NEEDLES or mesh.mesh.middles is not None:
        raise MeshError(
            f"{len(needles)} triangles lower than {height:.3g}, the first at {first}; {REMEDY}"
        )
    table = _Sides(mesh.mesh.triangles)
    left = needles.tolist()
    while left:
        waiting = [t for t in left if not table.turned(points, t, height)]
        if len(waiting) == len(left):
            stuck = place(points[table.triangles[left[0]]].mean(axis=0))
            raise MeshError(
                f"{len(left)} triangles lower than {height:.3g}, the first at {stuck}; {REMEDY}"
            )
        left = waiting
    if len(table.gone) == len(table.triangles):
        raise MeshError(
            f"no triangle of it has a height, the first lies at {first}; export it again"
        )
    mesh.mesh = replace(mesh.mesh, triangles=table.triangles)
    mesh.origin = mesh.origin[table.owners]
    mesh.take(np.setdiff1d(np.arange(len(table.triangles)), list(table.gone)))
    mesh.notes.append(f"{len(needles)} triangles without height turned, the first at {first}")


def _heights(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Height of each triangle over its longest edge."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    longest = np.max([np.linalg.norm(u, axis=1) for u in (b - a, c - b, a - c)], axis=0)
    return 2.0 * facet_areas(points, triangles) / np.maximum(longest, 1e-300)


class _Sides:
    """Triangles with the one at each directed side."""

    def __init__(self, triangles: np.ndarray) -> None:
        self.triangles = triangles.copy()
        self.owners = np.arange(len(triangles))
        self.gone: set[int] = set()
        starts, stops = triangles.ravel().tolist(), np.roll(triangles, -1, axis=1).ravel().tolist()
        self.at = {(a, b): i // 3 for i, (a, b) in enumerate(zip(starts, stops, strict=True))}

    def turned(self, points: np.ndarray, t: int, height: float) -> bool:
        """Turn one needle if that leaves better triangles; False to wait for its neighbour."""
        corners = self.triangles[t]
        sides = np.linalg.norm(points[np.roll(corners, -1)] - points[corners], axis=1)
        a, b, c = np.roll(corners, -int(np.argmax(sides))).tolist()
        other = self.at.get((b, a))
        if other is None:
            self._take_out(t)
            self.gone.add(t)
            return True
        (d,) = set(self.triangles[other].tolist()) - {a, b}
        if d == c or (c, d) in self.at or (d, c) in self.at:
            return False
        new = np.array([[c, a, d], [d, b, c]])
        if _heights(points, new).min() <= height:
            return False
        for triangle, corners in zip((t, other), new, strict=True):
            self._take_out(triangle)
            self.triangles[triangle] = corners
        for triangle in (t, other):
            x, y, z = self.triangles[triangle].tolist()
            self.at |= {(x, y): triangle, (y, z): triangle, (z, x): triangle}
        self.owners[t] = self.owners[other]
        return True

    def _take_out(self, t: int) -> None:
        x, y, z = self.triangles[t].tolist()
        for side in ((x, y), (y, z), (z, x)):
            if self.at.get(side) == t:
                del self.at[side]
