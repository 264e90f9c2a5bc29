"""A mesh on its way through repairs, with the file's triangle that each one comes from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import FacetMesh


class Mending:
    """A mesh on its way: triangles with the one of the file that each comes from."""

    def __init__(self, facets: FacetMesh, size: float, distance: float) -> None:
        self.mesh = replace(facets, groups={}, notes=())
        self.given = facets
        self.size, self.distance = size, distance
        self.origin = np.arange(len(facets.triangles))
        self.notes: list[str] = []

    def take(self, kept: np.ndarray) -> None:
        """Keep some triangles (a mask or indices)."""
        middles = self.mesh.middles
        self.mesh = replace(
            self.mesh,
            triangles=self.mesh.triangles[kept],
            middles=None if middles is None else middles[kept],
        )
        self.origin = self.origin[kept]

    def number(self, triangles: np.ndarray) -> None:
        """Other vertices for the same triangles."""
        self.mesh = replace(self.mesh, triangles=triangles)

    def result(self) -> FacetMesh:
        """Used points only, in their order; groups by origin."""
        used, triangles = np.unique(self.mesh.triangles, return_inverse=True)
        member = np.zeros(len(self.given.triangles), bool)
        groups, emptied = {}, []
        for name, own in self.given.groups.items():
            member[:] = False
            member[own] = True
            groups[name] = np.flatnonzero(member[self.origin])
            emptied += [] if len(groups[name]) else [f"'{name}'"]
        groups = {name: own for name, own in groups.items() if len(own)}
        notes = [*self.notes, f"groups left empty: {', '.join(emptied)}"] if emptied else self.notes
        reference = self.mesh.reference
        return FacetMesh(
            self.mesh.points[used],
            triangles.reshape(-1, 3),
            groups,
            self.mesh.middles,
            None if reference is None else reference[used],
            (*self.given.notes, *notes),
        )


def memberships(mesh: Mending) -> list[tuple[str, ...]]:
    """Names of the groups that each triangle of the file is in."""
    names: list[tuple[str, ...]] = [()] * len(mesh.given.triangles)
    for name, own in mesh.given.groups.items():
        for t in own.tolist():
            names[t] = (*names[t], name)
    return names
