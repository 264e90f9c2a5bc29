"""Continuous Bezier triangles on any triangulation: no valence rule, no ghosts, no remeshing.

Coefficients are the control points that neighbours share: vertices first (coefficient v is vertex
v), then ``p - 1`` along each edge from its smaller vertex, then the interior ones of each triangle.
Slopes may jump across edges: `shells.energy.kinks` ties them weakly.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, identity
from scipy.sparse.csgraph import connected_components

from ..local_elements import functions, lattice, triangle_exponents
from ..surface import Surface
from .edge_graph import SIDES, EdgeGraph, edge_graph


class TriangleSurface(Surface):
    """Bezier triangles with continuous densities of their own degree.

    Parameters
    ----------
    triangles : (n_elements, 3) int array
        Vertices ``0 .. n_vertices - 1``, all of them used, counterclockwise from outside.
    degree : {1, 2, 3}
        Of the geometry.
    density : {1, 2, 3}
        Of the continuous density functions.

    Raises
    ------
    ValueError
        Vertices left out or out of range, an edge of three or more triangles, or neighbours of
        opposite orientation.
    """

    shape = "triangle"

    def __init__(self, triangles: np.ndarray, degree: int = 3, density: int = 1):
        self.triangles = np.ascontiguousarray(triangles, dtype=np.int64)
        if self.triangles.ndim != 2 or self.triangles.shape[1] != 3 or not self.triangles.size:
            raise ValueError(f"expected triangles (n, 3), got shape {self.triangles.shape}")
        for name, p in (("degree", degree), ("density", density)):
            if p not in (1, 2, 3):
                raise ValueError(f"{name} of triangles must be 1, 2 or 3, got {p}")
        used = np.unique(self.triangles)
        if used[0] != 0 or used[-1] != used.size - 1:
            raise ValueError("vertices must be numbered 0 .. n - 1, each used by some triangle")
        self._degree, self._density_degree, self.n_vertices = degree, density, used.size

    @property
    def degree(self) -> int:
        return self._degree

    @property
    def density_degree(self) -> int:
        return self._density_degree

    @property
    def n_elements(self) -> int:
        return len(self.triangles)

    @cached_property
    def graph(self) -> EdgeGraph:
        """Edges with their triangles and sides."""
        return edge_graph(self.triangles)

    @cached_property
    def element_dofs(self) -> np.ndarray:
        return self._numbering(self.degree)

    def _numbering(self, p: int) -> np.ndarray:
        """Shared control points of each triangle, ``(n_elements, (p + 1) (p + 2) / 2)``."""
        place = {tuple(e): k for k, e in enumerate(triangle_exponents(p).tolist())}
        dofs = np.full((self.n_elements, len(place)), -1)
        for corner in range(3):
            dofs[:, place[tuple(p if k == corner else 0 for k in range(3))]] = self.triangles[
                :, corner
            ]
        start = self.n_vertices
        for side, (a, b) in enumerate(SIDES):
            upwards = self.triangles[:, a] < self.triangles[:, b]
            for k in range(1, p):
                exponents = [0, 0, 0]
                exponents[a], exponents[b] = p - k, k
                along = np.where(upwards, k, p - k) - 1
                dofs[:, place[tuple(exponents)]] = (
                    start + self.graph.of_triangle[:, side] * (p - 1) + along
                )
        start += len(self.graph.vertices) * (p - 1)
        inner = np.flatnonzero((triangle_exponents(p) > 0).all(axis=1))
        dofs[:, inner] = start + np.arange(self.n_elements * inner.size).reshape(
            self.n_elements, inner.size
        )
        return dofs

    @cached_property
    def n_coefficients(self) -> int:
        return self._count(self.degree)

    @cached_property
    def n_dofs(self) -> int:
        return self._count(self.density_degree)

    def _count(self, p: int) -> int:
        inner = (p - 1) * (p - 2) // 2
        return self.n_vertices + (p - 1) * len(self.graph.vertices) + inner * self.n_elements

    @cached_property
    def bezier(self) -> csr_matrix:
        columns = self.element_dofs.ravel()
        rows = np.arange(columns.size + 1)
        return csr_matrix(
            (np.ones(columns.size), columns, rows), (columns.size, self.n_coefficients)
        )

    @cached_property
    def pieces(self) -> np.ndarray:
        """Connected pieces of the triangles; those that share but a vertex are connected."""
        return self.coefficient_pieces[self.element_dofs[:, 0]]

    @cached_property
    def coefficient_pieces(self) -> np.ndarray:
        first = np.repeat(self.element_dofs[:, :1], self.element_dofs.shape[1], axis=1)
        pairs = (np.ones(first.size), (first.ravel(), self.element_dofs.ravel()))
        return connected_components(coo_matrix(pairs, 2 * (self.n_coefficients,)))[1]

    @property
    def reduction(self) -> csr_matrix:
        return identity(self.n_coefficients, format="csr")

    @cached_property
    def _density(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        dofs = self._numbering(self.density_degree)
        count = dofs.shape[1]
        extraction = np.tile(np.eye(count), (self.n_elements, 1))
        return count * np.arange(self.n_elements + 1), dofs.ravel(), extraction

    def on_edges(self, edges: np.ndarray) -> np.ndarray:
        """Coefficients on some edges, ends included, ``(n_edges, degree + 1)``.

        They run as the edge's first triangle does.
        """
        exponents = triangle_exponents(self.degree)
        rows = []
        for a, b in SIDES:
            on = np.flatnonzero(exponents[:, 3 - a - b] == 0)
            rows.append(on[np.argsort(exponents[on, b])])
        tri, side = self.graph.triangles[edges, 0], self.graph.sides[edges, 0]
        return self.element_dofs[tri[:, None], np.array(rows)[side]]

    @cached_property
    def rim_coefficients(self) -> np.ndarray:
        """Coefficients on the edges that only one triangle has, increasing."""
        return np.unique(self.on_edges(self.graph.rim))

    @property
    def open_edges(self) -> dict[str, csr_matrix]:
        # one by one: each of them may lie in another plane of symmetry
        identity_rows = identity(self.n_coefficients, format="csr")
        rim = self.graph.rim
        names = (f"({a}, {b})" for a, b in self.graph.vertices[rim])
        rows = self.on_edges(rim) if rim.size else rim
        return {name: identity_rows[row] for name, row in zip(names, rows, strict=True)}

    def interpolation(self, values: np.ndarray) -> np.ndarray:
        """Control points of the triangles through values on their even lattices.

        Parameters
        ----------
        values : (n_elements, n_functions, k) array
            At ``lattice("triangle", degree)``.

        Returns
        -------
        (n_elements, n_functions, k) array
        """
        xi, eta, _ = lattice("triangle", self.degree)
        inverse = np.linalg.inv(functions("triangle", self.degree, xi, eta))
        return np.einsum("ij,ejk->eik", inverse, values)

    def coefficients_of(self, control: np.ndarray) -> np.ndarray:
        """Coefficients of control points, means where neighbours share them.

        Parameters
        ----------
        control : (n_elements, n_functions, k) array

        Returns
        -------
        (n_coefficients, k) array

        Raises
        ------
        ValueError
            Control points of another shape.
        """
        if control.shape[:2] != self.element_dofs.shape:
            raise ValueError(
                f"expected control points {self.element_dofs.shape}, got {control.shape}"
            )
        flat = control.reshape(-1, control.shape[2])
        weights = 1.0 / np.bincount(self.element_dofs.ravel(), minlength=self.n_coefficients)
        return (self.bezier.T @ flat) * weights[:, None]
