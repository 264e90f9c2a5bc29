"""What all spline surfaces of one parameter grid share: Bezier elements, density tables, samples.

A surface names its elements, the coefficients that live on each and their Bezier extraction;
everything that the boundary elements of `hbem` ask of a surface follows.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
from scipy.sparse import block_diag, coo_matrix, csr_matrix, identity, kron
from scipy.sparse.csgraph import connected_components

from .splines import SplineSpace, bernstein


class TensorSurface(ABC):
    """A surface made of elements ``e_s * t.n_elements + e_t`` of a grid of two spline spaces.

    Attributes
    ----------
    s, t : SplineSpace
        Spaces of both directions, of one degree; outward normal is ``d_s x d_t``.
    """

    s: SplineSpace
    t: SplineSpace
    elements: np.ndarray | None
    shape = "quadrilateral"

    @property
    @abstractmethod
    def _grid_dofs(self) -> np.ndarray:
        """Grid numbers of the functions of each element, ``(n_elements, (p + 1) ** 2)``."""

    @property
    @abstractmethod
    def reduction(self) -> csr_matrix:
        """Scalar extraction ``(n_coefficients, k)``: coefficients of a smooth field from dofs."""

    @property
    @abstractmethod
    def open_edges(self) -> dict[str, np.ndarray]:
        """Coefficients along each edge that nothing closes, by the edge's name."""

    @cached_property
    def selected(self) -> np.ndarray:
        """Element numbers of the grid that this surface consists of, ``(n_elements,)``."""
        every = np.arange(self.s.n_elements * self.t.n_elements)
        return every if self.elements is None else np.unique(self.elements)

    @property
    def grid_edges(self) -> np.ndarray:
        """Pairs of grid elements with a common edge, ``(n, 2)``."""
        grid = np.arange(self.s.n_elements * self.t.n_elements)
        grid = grid.reshape(self.s.n_elements, self.t.n_elements)
        pairs = []
        for space, along in ((self.s, grid), (self.t, grid.T)):
            after = np.roll(along, -1, axis=0)
            last = None if space.periodic and space.n_elements > 1 else -1
            pairs.append(np.stack([along[:last].ravel(), after[:last].ravel()], axis=1))
        return np.concatenate(pairs)

    @cached_property
    def pieces(self) -> np.ndarray:
        """Which connected piece each element belongs to, ``(n_elements,)``: 0, 1, ..."""
        place = np.full(self.s.n_elements * self.t.n_elements, -1)
        place[self.selected] = np.arange(self.n_elements)
        i, j = place[self.grid_edges].T
        both = (i >= 0) & (j >= 0)
        graph = (np.ones(both.sum()), (i[both], j[both]))
        size = (self.n_elements, self.n_elements)
        return connected_components(coo_matrix(graph, size), directed=False)[1]

    @cached_property
    def _numbering(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Grid number and piece of each coefficient, coefficients of each element.

        Pieces share none: a function that spans a cut is one on either side of it.
        """
        n = int(self._grid_dofs.max()) + 1
        keys = self.pieces[:, None] * n + self._grid_dofs
        own, dofs = np.unique(keys, return_inverse=True)
        return own % n, own // n, dofs.reshape(keys.shape)

    @property
    def kept(self) -> np.ndarray:
        """Grid number of each coefficient, ``(n_coefficients,)``."""
        return self._numbering[0]

    @property
    def coefficient_pieces(self) -> np.ndarray:
        """The piece of each coefficient, ``(n_coefficients,)``."""
        return self._numbering[1]

    @property
    def element_dofs(self) -> np.ndarray:
        """Coefficients of each element, ``(n_elements, (p + 1) ** 2)``."""
        return self._numbering[2]

    @property
    def n_coefficients(self) -> int:
        """Rows of a coefficient array ``(n_coefficients, 3)``."""
        return self.kept.size

    def _own_reduction(self, full: csr_matrix) -> csr_matrix:
        """A reduction of grid coefficients as that of this surface's, piece by piece."""
        blocks = []
        for piece in range(self.pieces.max() + 1):
            rows = full[self.kept[self.coefficient_pieces == piece]]
            blocks.append(rows[:, np.flatnonzero(np.diff(rows.tocsc().indptr))])
        return block_diag(blocks, format="csr")

    @property
    def density_reduction(self) -> csr_matrix:
        """Scalar extraction of the density basis; that of smooth fields unless overridden."""
        return self.reduction

    @property
    def degree(self) -> int:
        """Polynomial degree p in each direction."""
        return self.s.degree

    geometry_degree = degree
    density_degree = degree

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.selected.size

    @cached_property
    def tables(self) -> np.ndarray:
        """Bezier extraction ``(n_elements, (p + 1) ** 2, (p + 1) ** 2)``."""
        es, et = np.divmod(self.selected, self.t.n_elements)
        product = np.einsum("eak,ebl->eabkl", self.s.extraction[es], self.t.extraction[et])
        nb = (self.degree + 1) ** 2
        return product.reshape(-1, nb, nb)

    @cached_property
    def bezier(self) -> csr_matrix:
        """Coefficients to Bezier points, ``(n_elements (p + 1)**2, n_coefficients)``."""
        nb = (self.degree + 1) ** 2
        rows = np.arange(self.n_elements * nb).reshape(-1, 1, nb)
        rows = np.broadcast_to(rows, self.tables.shape)
        cols = np.broadcast_to(self.element_dofs[:, :, None], self.tables.shape)
        shape = (self.n_elements * nb, self.n_coefficients)
        return coo_matrix((self.tables.ravel(), (rows.ravel(), cols.ravel())), shape).tocsr()

    @property
    def n_dofs(self) -> int:
        """Number of scalar density functions."""
        return self.density_reduction.shape[1]

    @cached_property
    def _density(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nb = (self.degree + 1) ** 2
        local = (self.bezier @ self.density_reduction).tocoo()
        element, k = np.divmod(local.row.astype(np.int64), nb)
        keys, row = np.unique(element * self.n_dofs + local.col, return_inverse=True)
        extraction = np.zeros((keys.size, nb))
        extraction[row, k] = local.data
        owner, dofs = np.divmod(keys, self.n_dofs)
        counts = np.bincount(owner, minlength=self.n_elements)
        return np.concatenate([[0], np.cumsum(counts)]), dofs, extraction

    @property
    def indptr(self) -> np.ndarray:
        """Density functions of element e are rows ``indptr[e]`` to ``indptr[e + 1]`` of `dofs`."""
        return self._density[0]

    @property
    def dofs(self) -> np.ndarray:
        """Density dof of each row."""
        return self._density[1]

    @property
    def extraction(self) -> np.ndarray:
        """Bezier coefficients of each row, ``(n_rows, (p + 1) ** 2)``."""
        return self._density[2]

    def sample(self, xi: np.ndarray, eta: np.ndarray, along: int | None = None) -> csr_matrix:
        """Coefficients to points at local ``xi``, ``eta`` of every element.

        Parameters
        ----------
        xi, eta : (n,) array
            Local coordinates in [0, 1].
        along : {0, 1}, optional
            Derivative along local s or t instead of the value.

        Returns
        -------
        (n_elements * n, n_coefficients) sparse matrix
        """
        p = self.degree
        values = bernstein(p, xi, int(along == 0))[:, None] * bernstein(p, eta, int(along == 1))
        local = csr_matrix(values.reshape(-1, np.size(xi)).T)
        return kron(identity(self.n_elements), local, format="csr") @ self.bezier
