"""Triangles on sample points of a smooth surface, and what `ipctk` finds out about them.

Samples that coincide at rest are one vertex, so that neighbouring elements share vertices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

COINCIDE = 1e-8  # distance of samples that are one, over the surface's size
MOST_PIECES = 16  # of a straight way that is tested for contact


@dataclass(frozen=True)
class SampledMesh:
    """Triangles of a surface at any configuration.

    Attributes
    ----------
    sample : (n, n_coefficients) sparse matrix
        Coefficients to vertices.
    triangles : (m, 3) int array
    cells : (m,) int array
        Quadrilateral that each triangle is half of.
    """

    sample: csr_matrix
    triangles: np.ndarray
    cells: np.ndarray

    @classmethod
    def of(cls, sampling: csr_matrix, cells: np.ndarray, rest: np.ndarray) -> SampledMesh:
        """Mesh of quadrilaterals of sample points.

        They are cut along their shorter diagonal at rest: the longer one runs through a vertex
        where a pillow's corner flattens an element. Triangles without area are left out.

        Parameters
        ----------
        sampling : (n_samples, n_coefficients) sparse matrix
        cells : (k, 4) int array
            Sample points of each quadrilateral, in turn.
        rest : (n_coefficients, 3) array
            A configuration without contact.
        """
        vertex, sample = _merged(sampling, rest)
        triangles = halve_quadrilaterals(vertex[cells], sample @ rest)
        return cls._proper(sample, triangles, np.tile(np.arange(len(cells)), 2))

    @classmethod
    def of_triangles(
        cls, sampling: csr_matrix, triangles: np.ndarray, rest: np.ndarray
    ) -> SampledMesh:
        """Mesh of triangles of sample points; those without area are left out.

        Parameters
        ----------
        sampling : (n_samples, n_coefficients) sparse matrix
        triangles : (m, 3) int array
            All turning the same way round the outward normal.
        rest : (n_coefficients, 3) array
            A configuration without contact.
        """
        vertex, sample = _merged(sampling, rest)
        return cls._proper(sample, vertex[triangles], np.arange(len(triangles)))

    @classmethod
    def union(cls, parts: Sequence[SampledMesh]) -> SampledMesh:
        """Several surfaces; coefficients, vertices and cells one after the other.

        They are not joined where they coincide.
        """
        vertices = np.cumsum([0] + [p.sample.shape[0] for p in parts])
        cells = np.cumsum([0] + [p.cells.max(initial=-1) + 1 for p in parts])
        return cls(
            block_diag([p.sample for p in parts], format="csr"),
            np.concatenate([p.triangles + v for p, v in zip(parts, vertices[:-1], strict=True)]),
            np.concatenate([p.cells + k for p, k in zip(parts, cells[:-1], strict=True)]),
        )

    @classmethod
    def _proper(cls, sample: csr_matrix, triangles: np.ndarray, cells: np.ndarray) -> SampledMesh:
        """Without triangles that have a vertex twice."""
        a, b, c = triangles.T
        proper = (a != b) & (b != c) & (c != a)
        return cls(sample, triangles[proper], cells[proper])

    def part(self, chosen: np.ndarray) -> SampledMesh:
        """Some of the triangles ``(m,)`` bool, and their vertices (others would collide, too)."""
        used, vertices = np.unique(self.triangles[chosen], return_inverse=True)
        return SampledMesh(self.sample[used], vertices.reshape(-1, 3), self.cells[chosen])

    def shortest_edge(self, coefficients: np.ndarray) -> float:
        """Length of the shortest edge of a triangle."""
        corners = (self.sample @ coefficients)[self.triangles]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min())

    def intersects(self, coefficients: np.ndarray) -> bool:
        """Whether triangles of this configuration cross each other."""
        ipctk = _quiet_ipctk()
        points = np.asfortranarray(self.sample @ coefficients)
        return bool(ipctk.has_intersections(self._collision_mesh, points))

    def reaches(self, start: np.ndarray, end: np.ndarray) -> bool:
        """Whether the end is free of contact, and so is the straight way there."""
        return not self.intersects(end) and self.free_step(start, end) >= 1.0

    def free_step(
        self, start: np.ndarray, end: np.ndarray, distance: float = 0.0, piece: float = np.inf
    ) -> float:
        """Fraction of the straight way between two configurations that is free of contact.

        Parameters
        ----------
        start, end : (n_coefficients, 3) array
            The first of them without contact.
        distance : float
            Closest that triangles may come to each other.
        piece : float
            Longest motion that is looked at in one go: pieces of a long way have fewer pairs of
            triangles together than the whole, and those after a contact are not looked at.
        """
        ipctk = _quiet_ipctk()
        a = self.sample @ start
        way = self.sample @ end - a
        way -= way.mean(axis=0)  # a common translation brings nothing together
        longest = float(np.sqrt(np.einsum("ij,ij->i", way, way).max()))
        count = int(np.clip(np.ceil(longest / piece), 1, MOST_PIECES))
        for k in range(count):
            low, high = (np.asfortranarray(a + (i / count) * way) for i in (k, k + 1))
            free = ipctk.compute_collision_free_stepsize(
                self._collision_mesh, low, high, distance, narrow_phase_ccd=ipctk.AdditiveCCD()
            )
            if free < 1.0:
                return (k + float(free)) / count
        return 1.0

    def areas(self, coefficients: np.ndarray) -> np.ndarray:
        """Area ``(n,)`` of each vertex: a third of its triangles', in some configuration."""
        corners = (self.sample @ coefficients)[self.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        third = np.repeat(np.linalg.norm(normals, axis=1) / 6.0, 3)
        return np.bincount(self.triangles.ravel(), third, minlength=self.sample.shape[0])

    @cached_property
    def _collision_mesh(self) -> Any:
        """Edges and faces as ipctk keeps them; only how they hang together counts here."""
        ipctk = _quiet_ipctk()
        faces = np.asfortranarray(self.triangles.astype(np.int32))
        edges = np.asfortranarray(ipctk.edges(faces))
        nowhere = np.zeros((self.sample.shape[0], 3), order="F")
        return ipctk.CollisionMesh(nowhere, edges, faces)


def _quiet_ipctk() -> ModuleType:
    """ipctk, loaded when first needed; it prints warnings of touching starts, which we judge."""
    import ipctk

    ipctk.set_logger_level(ipctk.LoggerLevel.error)
    return ipctk


def _merged(sampling: csr_matrix, rest: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
    """Vertex of each sample, those that coincide at rest being one, and the vertices' sampling."""
    points = sampling @ rest
    near = COINCIDE * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
    shape = (len(points), len(points))
    graph = csr_matrix((np.ones(len(pairs)), pairs.T), shape=shape)
    vertex = connected_components(graph, directed=False)[1]
    _, first = np.unique(vertex, return_index=True)
    return vertex, sampling.tocsr()[first]


def halve_quadrilaterals(cells: np.ndarray, points: np.ndarray) -> np.ndarray:
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
