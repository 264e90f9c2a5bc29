"""Points, normals and grids of a bag's configurations, for diagnostics, files and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import block_diag

from coupling.contact.sampled_mesh import SampledMesh
from coupling.contact.smallest_gap import minimum_gap
from shells.surfaces.local_elements import lattice, middle
from shells.surfaces.surface import Surface
from shells.surfaces.triangles.lagrange_nodes import lagrange_order

from .bag import Bag

GAP_CELLS = 2  # per element side, two triangles each


def triangulated(body: Bag, cells: int) -> SampledMesh:
    """Triangles of a bag, ``cells`` an element side; samples of neighbours are made one.

    Cells are numbered element by element, ``cells ** 2`` each.
    """
    shape = body.membrane.shape
    xi, eta, each = lattice(shape, cells)
    sampling = block_diag([part.sample(xi, eta) for part in body.parts], format="csr")
    elements = sum(part.n_elements for part in body.parts)
    every = (xi.size * np.arange(elements)[:, None, None] + each).reshape(-1, each.shape[1])
    make = SampledMesh.of_triangles if shape == "triangle" else SampledMesh.of
    return make(sampling, every, body.coefficients)


def corner_triangles(surface: Surface, coefficients: np.ndarray) -> np.ndarray:
    """Flat triangles ``(n, 3, 3)`` between the corners of the elements."""
    xi, eta, cells = lattice(surface.shape, 1)
    corners = (surface.sample(xi, eta) @ coefficients).reshape(-1, xi.size, 3)
    halves = [cells[0, [0, k, k + 1]] for k in range(1, cells.shape[1] - 1)]
    return np.concatenate([corners[:, half] for half in halves])


def tangents(
    surface: Surface, coefficients: np.ndarray, points: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Both tangents at local points of every element, ``(n, 3)`` each."""
    s, t = (surface.sample(*points, k) @ coefficients for k in (0, 1))
    return s, t


def element_areas(surface: Surface, coefficients: np.ndarray) -> np.ndarray:
    """Area of each element from the tangents at its middle, ``(n_elements,)``."""
    xi, eta, local = middle(surface.shape)
    return local * np.linalg.norm(np.cross(*tangents(surface, coefficients, (xi, eta))), axis=1)


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
        """Cells with point data, for files and pictures.

        Parameters
        ----------
        coefficients, velocity : (n_full, 3) array
        traction : (n_density, 3) array, optional
            Density coefficients (membrane, then patch).
        tessellate : int
            Cells per element and direction; the order of curved triangles.

        Returns
        -------
        dict
            ``points (n, 3)``, ``quads (m, 4)`` or ``curved (n_elements, k)``, ``point_data``,
            ``cell_data``.
        """
        shape = self.body.membrane.shape
        xi, eta, each = lattice(shape, tessellate)
        if shape == "triangle":
            each = lagrange_order(tessellate)[None]
        points, part_of = [], []
        data: dict[str, list[np.ndarray]] = {"traction": [], "velocity": []}
        velocity = np.zeros_like(coefficients) if velocity is None else velocity
        ends = np.cumsum([part.n_dofs for part in self.body.parts])[:-1]
        tractions = None if traction is None else np.split(traction, ends)
        for k, part in enumerate(self.body.parts):
            sample = part.sample(xi, eta)
            points.append(sample @ self.split(coefficients)[k])
            part_of.append(np.full(part.n_elements * len(each), k))
            data["velocity"].append(sample @ self.split(velocity)[k])
            if tractions is not None:
                data["traction"].append(part.sample_density(xi, eta) @ tractions[k])
        places = np.concatenate(points)
        first = xi.size * np.arange(len(places) // xi.size)[:, None, None]
        return {
            "points": places,
            "curved" if shape == "triangle" else "quads": (first + each).reshape(-1, each.shape[1]),
            "point_data": {name: np.concatenate(v) for name, v in data.items() if v},
            "cell_data": {"part": np.concatenate(part_of)},
        }
