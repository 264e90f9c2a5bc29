"""What all spline surfaces of one parameter grid share: Bezier elements, density tables, samples.

A surface names its elements, the coefficients that live on each and their Bezier extraction;
everything that the boundary elements of `hbem` ask of a surface follows.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from .splines import SplineSpace
from .surface import Surface


class TensorSurface(Surface):
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

    @cached_property
    def selected(self) -> np.ndarray:
        """Element numbers of the grid that this surface consists of, ``(n_elements,)``."""
        every = np.arange(self.s.n_elements * self.t.n_elements)
        return every if self.elements is None else np.unique(self.elements)

    def beside(self, direction: str, step: int) -> np.ndarray:
        """Neighbour of each grid element across one of its edges.

        Parameters
        ----------
        direction : {"s", "t"}
        step : {-1, 1}
            Towards the start or the end of that direction.

        Returns
        -------
        (n_grid,) int array
            -1 where the grid ends; the element itself where its edge is a pole.
        """
        shape = (self.s.n_elements, self.t.n_elements)
        grid = np.arange(shape[0] * shape[1]).reshape(shape)
        axis, space = (0, self.s) if direction == "s" else (1, self.t)
        neighbours = np.roll(grid, -step, axis)
        if not space.periodic:
            np.moveaxis(neighbours, axis, 0)[-1 if step > 0 else 0] = -1
        return neighbours.ravel()

    def _across(self, direction: str, step: int) -> np.ndarray:
        """Row of the neighbour in `selected` by element: -1 where the grid ends, -2 where cut."""
        place = np.full(self.s.n_elements * self.t.n_elements + 1, -2)
        place[self.selected] = np.arange(self.n_elements)
        place[-1] = -1
        return place[self.beside(direction, step)[self.selected]]

    @cached_property
    def pieces(self) -> np.ndarray:
        """Which connected piece each element belongs to, ``(n_elements,)``: 0, 1, ..."""
        across = np.stack([self._across(d, step) for d in "st" for step in (-1, 1)])
        i = np.broadcast_to(np.arange(self.n_elements), across.shape)[across >= 0]
        graph = coo_matrix((np.ones(i.size), (i, across[across >= 0])), 2 * (self.n_elements,))
        return connected_components(graph, directed=False)[1]

    @property
    def open_edges(self) -> dict[str, csr_matrix]:
        """Coefficients to Bezier points ``(n_points, n_coefficients)`` of each edge that nothing
        closes, by its name; none for a closed surface."""
        nb = np.arange((self.degree + 1) ** 2).reshape(self.degree + 1, self.degree + 1)
        rows: dict[str, list[np.ndarray]] = {}
        for direction in "st":
            for end, word in enumerate(("start", "end")):
                across = self._across(direction, 2 * end - 1)
                side = nb[-end] if direction == "s" else nb[:, -end]
                named = ((-1, f"{direction} = {word}"), (-2, "at the rim of the restriction"))
                for mark, name in named:
                    e = np.flatnonzero(across == mark)
                    if e.size:
                        points = (e[:, None] * nb.size + side).ravel()
                        rows.setdefault(name, []).append(points)
        return {name: self.bezier[np.unique(np.concatenate(r))] for name, r in rows.items()}

    @cached_property
    def _numbering(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Grid number and piece of each coefficient, coefficients of each element.

        A function that a cut or a slit divides is one on either side: its parts share no edge.
        """
        parts, count = self._parts()
        keys = self._grid_dofs * count + parts
        own, first, dofs = np.unique(keys, return_index=True, return_inverse=True)
        return own // count, self.pieces[first // keys.shape[1]], dofs.reshape(keys.shape)

    def _parts(self) -> tuple[np.ndarray, int]:
        """Connected part of its function that each function of each element belongs to."""
        dofs = self._grid_dofs
        if self.elements is None:
            return np.zeros_like(dofs), 1
        number = np.arange(dofs.size).reshape(dofs.shape)
        pairs = []
        for direction in "st":
            for step in (-1, 1):  # both: at a zipped end only one of them crosses it
                after = self._across(direction, step)
                here = np.flatnonzero(after >= 0)
                there = after[here]
                k, a, b = np.nonzero(dofs[here][:, :, None] == dofs[there][:, None, :])
                pairs.append(np.stack([number[here[k], a], number[there[k], b]]))
        i, j = np.concatenate(pairs, axis=1)
        graph = coo_matrix((np.ones(i.size), (i, j)), 2 * (dofs.size,))
        count, parts = connected_components(graph, directed=False)
        return parts.reshape(dofs.shape), count

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
        """A reduction of grid coefficients as that of this surface's.

        Parts of a divided function that follow no others are dofs of their own; constraints (a
        pole, a corner) hold piece by piece.
        """
        rows = full[self.kept].tocoo()
        alone = np.bincount(full.tocoo().col, minlength=full.shape[1]) == 1
        owner = np.where(alone[rows.col], rows.row, self.coefficient_pieces[rows.row])
        keys = rows.col.astype(np.int64) * self.n_coefficients + owner
        used, columns = np.unique(keys, return_inverse=True)
        shape = (self.n_coefficients, used.size)
        return csr_matrix((rows.data, (rows.row, columns)), shape)

    @property
    def density_reduction(self) -> csr_matrix:
        """Scalar extraction of the density basis; that of smooth fields unless overridden."""
        return self.reduction

    @property
    def degree(self) -> int:
        """Polynomial degree p in each direction."""
        return self.s.degree

    @property
    def element_numbers(self) -> np.ndarray:
        """Those of the grid."""
        return self.selected

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
