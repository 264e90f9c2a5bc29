"""Grids of a bag with what contact and wrinkles do on it: further fields of files and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from coupling.contact.sampled_mesh import SampledMesh, halve_quadrilaterals

from .bag_sampler import BagSampler

if TYPE_CHECKING:
    from shells.energy.kirchhoff_love import KirchhoffLove

AT_REST = 1e-10  # strains below which the signs of strains are rounding


@dataclass(frozen=True)
class ContactLoad:
    """Pressure ``(n,)`` at the vertices of a sampled bag, of coefficients ``(n_full, 3)``."""

    mesh: SampledMesh
    pressure: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Zones:
    """Where the membrane is taut (0), wrinkled (1) or slack (2).

    Attributes
    ----------
    points : (2, n_points) array
        Local coordinates in [0, 1] that all elements are looked at.
    state : callable
        Membrane coefficients to the state ``(n_elements, n_points)`` at these points.
    """

    points: np.ndarray
    state: Callable[[np.ndarray], np.ndarray]

    @classmethod
    def of(cls, shell: KirchhoffLove) -> Zones:
        """Zones of a shell at its quadrature points."""
        from shells.energy.stress import wrinkling

        def state(coefficients: np.ndarray) -> np.ndarray:
            found = wrinkling(shell, coefficients)
            return np.where(np.abs(found.strains).max(axis=-1) > AT_REST, found.state, 0)

        return cls(shell.basis.X, state)


@dataclass(frozen=True)
class BagFields:
    """Grids of `BagSampler` with ``contact_pressure`` at points and ``wrinkling`` of cells.

    Attributes
    ----------
    sampler : BagSampler
    contact : ContactLoad, optional
    zones : Zones, optional
        Cells take the state of the nearest point; the inlet counts as taut.
    """

    sampler: BagSampler
    contact: ContactLoad | None = None
    zones: Zones | None = None

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
        if self.zones is not None:
            grid["cell_data"]["wrinkling"] = self._states(coefficients, tessellate)
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

    def _states(self, coefficients: np.ndarray, tessellate: int) -> np.ndarray:
        assert self.zones is not None
        body = self.sampler.body
        state = self.zones.state(coefficients[: body.n_membrane])
        middle = (np.arange(tessellate) + 0.5) / tessellate
        centres = np.stack([g.ravel() for g in np.meshgrid(middle, middle, indexing="ij")], axis=1)
        nearest = cKDTree(np.asarray(self.zones.points).T).query(centres)[1]
        inlet = sum(part.n_elements for part in body.parts) - len(state)
        return np.concatenate([state[:, nearest].ravel(), np.zeros(inlet * tessellate**2, int)])


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals ``(n, 3)`` at vertices, means of their triangles by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross, owner = np.repeat(np.cross(b - a, c - a), 3, axis=0), triangles.ravel()
    n = np.stack([np.bincount(owner, x, minlength=len(points)) for x in cross.T], axis=1)
    return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)
