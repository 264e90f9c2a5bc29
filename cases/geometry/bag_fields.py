"""Grids of a bag with the pressure of contact on it: a further field of files and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from coupling.contact.sampled_mesh import SampledMesh, halve_quadrilaterals

from .bag_sampler import BagSampler


@dataclass(frozen=True)
class ContactLoad:
    """Pressure ``(n,)`` at the vertices of a sampled bag, of coefficients ``(n_full, 3)``."""

    mesh: SampledMesh
    pressure: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class BagFields:
    """Grids of a sampler with ``contact_pressure`` at points.

    Attributes
    ----------
    sampler : BagSampler
    contact : ContactLoad, optional
    """

    sampler: BagSampler
    contact: ContactLoad | None = None

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None = None,
        velocity: np.ndarray | None = None,
        tessellate: int = 3,
    ) -> dict[str, Any]:
        """Quadrilaterals with point and cell data; see `BagSampler.surface_grid`."""
        grid: dict[str, Any] = self.sampler.surface_grid(
            coefficients, traction, velocity, tessellate
        )
        if self.contact is not None:
            pressure = self.contact.pressure(coefficients)[self._vertices(tessellate)]
            grid["point_data"]["contact_pressure"] = pressure
        return grid

    def _vertices(self, tessellate: int) -> np.ndarray:
        """Vertex of the sampled mesh at, or nearest to, each point of a grid."""
        if tessellate not in self._known:
            assert self.contact is not None
            rest, mesh = self.sampler.body.coefficients, self.contact.mesh
            grid: dict[str, Any] = self.sampler.surface_grid(rest, tessellate=tessellate)
            halves = halve_quadrilaterals(grid["quads"], grid["points"])
            vertices = mesh.sample @ rest
            # both sheets of a panel may be nearer than neighbours; their normals oppose each other
            size = np.ptp(vertices, axis=0).max()
            keys = [
                np.hstack([points, size * _normals(points, triangles)])
                for points, triangles in ((vertices, mesh.triangles), (grid["points"], halves))
            ]
            self._known[tessellate] = cKDTree(keys[0]).query(keys[1])[1]
        return self._known[tessellate]

    @cached_property
    def _known(self) -> dict[int, np.ndarray]:
        return {}


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals ``(n, 3)`` at vertices, means of their triangles by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross, owner = np.repeat(np.cross(b - a, c - a), 3, axis=0), triangles.ravel()
    n = np.stack([np.bincount(owner, x, minlength=len(points)) for x in cross.T], axis=1)
    return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)
