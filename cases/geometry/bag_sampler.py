"""Points, normals and grids of a bag's configurations, for diagnostics, files and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import block_diag

from coupling.contact.sampled_mesh import SampledMesh, grid_cells
from coupling.contact.smallest_gap import minimum_gap

from .bag import Bag

GAP_CELLS = 2  # per element side, two triangles each


def triangulated(body: Bag, cells: int) -> SampledMesh:
    """Triangles of a bag, ``cells`` an element side; samples of neighbours are made one."""
    x = np.linspace(0.0, 1.0, cells + 1)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    sampling = block_diag([part.sample(xi, eta) for part in body.parts], format="csr")
    elements = sum(part.n_elements for part in body.parts)
    return SampledMesh.of(sampling, grid_cells(elements, cells + 1), body.coefficients)


@dataclass(frozen=True)
class BagSampler:
    """Points, normals and grids of a configuration for diagnostics and pictures."""

    body: Bag

    @cached_property
    def _triangles(self) -> SampledMesh:
        return triangulated(self.body, GAP_CELLS)

    def split(self, field: np.ndarray) -> list[np.ndarray]:
        """Rows of each part of an array ``(n_full, 3)``."""
        return np.split(field, np.cumsum([p.n_coefficients for p in self.body.parts])[:-1])

    def gap(self, coefficients: np.ndarray) -> float:
        """Smallest gap between facing parts of the bag."""
        mesh = self._triangles
        return minimum_gap(mesh.sample @ coefficients, mesh.triangles, self.body.gap)

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None = None,
        velocity: np.ndarray | None = None,
        tessellate: int = 3,
    ) -> dict[str, object]:
        """Quadrilaterals with point data, for files and pictures.

        Parameters
        ----------
        coefficients, velocity : (n_full, 3) array
        traction : (n_density, 3) array, optional
            Density coefficients (membrane, then patch).
        tessellate : int
            Cells per element and direction.

        Returns
        -------
        dict
            ``points (n, 3)``, ``quads (m, 4)``, ``point_data``, ``cell_data``.
        """
        n = tessellate + 1
        x = np.linspace(0.0, 1.0, n)
        xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
        i, j = (g.ravel() for g in np.meshgrid(range(tessellate), range(tessellate), indexing="ij"))
        cell = np.stack([i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1], axis=1)
        points, quads, part_of = [], [], []
        data: dict[str, list[np.ndarray]] = {"traction": [], "velocity": []}
        start = 0
        velocity = np.zeros_like(coefficients) if velocity is None else velocity
        ends = np.cumsum([part.n_dofs for part in self.body.parts])[:-1]
        tractions = None if traction is None else np.split(traction, ends)
        for k, part in enumerate(self.body.parts):
            sample = part.sample(xi, eta)
            points.append(sample @ self.split(coefficients)[k])
            offsets = start + np.arange(part.n_elements) * n * n
            quads.append((offsets[:, None, None] + cell).reshape(-1, 4))
            part_of.append(np.full(part.n_elements * tessellate**2, k))
            data["velocity"].append(sample @ self.split(velocity)[k])
            if tractions is not None:
                data["traction"].append(sample @ (part.density_reduction @ tractions[k]))
            start += points[-1].shape[0]
        return {
            "points": np.concatenate(points),
            "quads": np.concatenate(quads),
            "point_data": {name: np.concatenate(v) for name, v in data.items() if v},
            "cell_data": {"part": np.concatenate(part_of)},
        }
