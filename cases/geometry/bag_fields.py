"""Grids of a bag with the pressure of contact on it: a further field of files and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from coupling.contact.sampled_mesh import SampledMesh

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
        """Cells with point and cell data; see `BagSampler.surface_grid`."""
        grid: dict[str, Any] = self.sampler.surface_grid(
            coefficients, traction, velocity, tessellate
        )
        if self.contact is not None:
            pressure = self.contact.pressure(coefficients)[self._vertices(tessellate)]
            grid["point_data"]["contact_pressure"] = pressure
        return grid

    def _vertices(self, tessellate: int) -> np.ndarray:
        """Vertex of the sampled mesh at, or in the same element nearest to, each point of a grid.

        Elements tell sheets and turns of a roll apart, which may be nearer than neighbours.
        """
        if tessellate not in self._known:
            assert self.contact is not None
            body, mesh = self.sampler.body, self.contact.mesh
            grid: dict[str, Any] = self.sampler.surface_grid(
                body.coefficients, tessellate=tessellate
            )
            n_elements = sum(part.n_elements for part in body.parts)
            cells = (int(mesh.cells.max()) + 1) // n_elements
            vertices, element = mesh.triangles.ravel(), np.repeat(mesh.cells // cells, 3)
            points = mesh.sample @ body.coefficients
            apart = 10.0 * np.ptp(points, axis=0).max()
            known = np.column_stack([points[vertices], apart * element])
            asked = np.repeat(np.arange(n_elements), len(grid["points"]) // n_elements)
            found = cKDTree(known).query(np.column_stack([grid["points"], apart * asked]))[1]
            self._known[tessellate] = vertices[found]
        return self._known[tessellate]

    @cached_property
    def _known(self) -> dict[int, np.ndarray]:
        return {}
