"""Certificates against self-intersection: continuous surfaces by way of sampled triangles.

A mesh whose triangles do not cross certifies the smooth surface up to its chordal error,
``edge^2 curvature / 8`` a sheet. Needs `ipctk` (the optional extra ``contact``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree


def available() -> bool:
    """Whether the optional extra ``contact`` is installed."""
    return find_spec("ipctk") is not None


@dataclass(frozen=True)
class Certificate:
    """Checks configurations of one surface.

    Parameters
    ----------
    sampling : (n_samples, n_coefficients) sparse matrix
        Coefficients to sample points; points that coincide at rest are one vertex.
    cells : (n, 4) int array
        Quadrilaterals of sample points, cut into triangles along their shorter diagonal at rest:
        the longer one runs through a vertex where a pillow's corner flattens an element.
    rest : (n_coefficients, 3) array
        A configuration without contact.

    Raises
    ------
    ModuleNotFoundError
        On use, without the extra ``contact``.
    """

    sampling: csr_matrix
    cells: np.ndarray
    rest: np.ndarray

    @cached_property
    def _merged(self) -> tuple[csr_matrix, np.ndarray]:
        """Sampling of distinct vertices, and triangles of those."""
        points = self.sampling @ self.rest
        scale = np.ptp(points, axis=0).max()
        pairs = cKDTree(points).query_pairs(1e-9 * scale, output_type="ndarray")
        n = points.shape[0]
        graph = coo_matrix((np.ones(len(pairs)), pairs.T.reshape(2, -1)), shape=(n, n))
        _, vertex = connected_components(graph, directed=False)
        _, first = np.unique(vertex, return_index=True)
        vertices = self.sampling.tocsr()[first]
        triangles = halved(vertex[self.cells], vertices @ self.rest)
        proper = (
            (triangles[:, 0] != triangles[:, 1])
            & (triangles[:, 1] != triangles[:, 2])
            & (triangles[:, 2] != triangles[:, 0])
        )
        return vertices, triangles[proper].astype(np.int32)

    @cached_property
    def _mesh(self) -> Any:
        import ipctk

        sampling, triangles = self._merged
        rest = np.asfortranarray(sampling @ self.rest)
        faces = np.asfortranarray(triangles)
        return ipctk.CollisionMesh(rest, np.asfortranarray(ipctk.edges(faces)), faces)

    def vertices(self, coefficients: np.ndarray) -> np.ndarray:
        """Distinct sample points ``(n, 3)``."""
        return np.asfortranarray(self._merged[0] @ coefficients)

    @property
    def faces(self) -> np.ndarray:
        """Triangles of `vertices`."""
        return self._merged[1]

    def shortest_edge(self, coefficients: np.ndarray) -> float:
        """Length of the shortest edge of a triangle."""
        corners = self.vertices(coefficients)[self.faces]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min())

    def intersects(self, coefficients: np.ndarray) -> bool:
        """Whether triangles of this configuration cross each other."""
        import ipctk

        return bool(ipctk.has_intersections(self._mesh, self.vertices(coefficients)))

    def free_step(self, start: np.ndarray, end: np.ndarray, distance: float = 0.0) -> float:
        """Fraction of the straight way from ``start`` to ``end`` without contact.

        Parameters
        ----------
        start, end : (n_coefficients, 3) array
        distance : float
            Closest that triangles may come to each other.
        """
        import ipctk

        return float(
            ipctk.compute_collision_free_stepsize(
                self._mesh,
                self.vertices(start),
                self.vertices(end),
                min_distance=distance,
                narrow_phase_ccd=ipctk.AdditiveCCD(),
            )
        )


def halved(cells: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Both halves of each quadrilateral along its shorter diagonal, first halves first."""
    a, b, c, d = cells.T
    length = np.linalg.norm(points[a] - points[c], axis=1)
    turn = np.linalg.norm(points[b] - points[d], axis=1) < length
    a, b, c, d = np.where(turn, [b, c, d, a], [a, b, c, d])
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def grid_cells(n_elements: int, points: int) -> np.ndarray:
    """Quadrilaterals of ``points x points`` samples an element, second direction fastest."""
    i, j = (g.ravel() for g in np.meshgrid(*2 * [np.arange(points - 1)], indexing="ij"))
    first = i * points + j
    cell = np.stack([first, first + points, first + points + 1, first + 1], axis=1)
    return (points**2 * np.arange(n_elements)[:, None, None] + cell).reshape(-1, 4)
