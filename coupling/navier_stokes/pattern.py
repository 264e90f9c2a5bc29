"""The free unknowns in their order of elimination and the one sparsity pattern of all tangents.

Tangents differ only in the convection of the flagged elements: their matrices are added into a
data array at places that are known beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array

from .ordering import dissection
from .spaces import FlowSpace


@dataclass(frozen=True)
class Pattern:
    """Sparsity of the free unknowns.

    Attributes
    ----------
    order : (n_free,) int array
        Free unknowns as they are eliminated.
    indices, indptr : int arrays
        Of the tangent as ``csc_array``.
    places : (n_elements, 2 k, 2 k) int array
        Where velocity couplings of an element lie in the data; ``nnz`` for prescribed ones.
    """

    order: np.ndarray
    indices: np.ndarray
    indptr: np.ndarray
    places: np.ndarray

    @property
    def nnz(self) -> int:
        """Number of entries."""
        return self.indices.size

    def data(self, matrix: csr_array) -> np.ndarray:
        """Data of a matrix of all unknowns, restricted to the free ones."""
        part = csc_array(matrix[self.order][:, self.order])
        part.sum_duplicates()
        column = np.repeat(np.arange(self.order.size), np.diff(part.indptr))
        result = np.zeros(self.nnz)
        result[_places(self.indices, self.indptr, part.indices, column)] = part.data
        return result

    def matrix(self, data: np.ndarray) -> csc_array:
        """Matrix of the free unknowns from its data."""
        shape = (self.order.size, self.order.size)
        return csc_array((data, self.indices, self.indptr), shape=shape)

    def add(self, data: np.ndarray, rows: np.ndarray, blocks: np.ndarray) -> None:
        """Add element matrices ``(m, 2 k, 2 k)`` of the elements ``rows`` to the data in place."""
        places = self.places[rows].ravel()
        data += np.bincount(places, blocks.ravel(), minlength=self.nnz + 1)[:-1]


def pattern(space: FlowSpace, fixed: np.ndarray) -> Pattern:
    """Pattern of a space whose unknowns ``fixed`` (n,) are prescribed."""
    dofs = space.element_dofs
    last = np.arange(space.n) >= 2 * space.n_velocity
    order = dissection(dofs, space.centres, last)
    order = order[~fixed[order]]
    number = np.full(space.n, -1)
    number[order] = np.arange(order.size)
    local = number[dofs]
    indices, indptr = _couplings(local, order.size)
    velocity = local[: 2 * space.velocity.Nbfun].T
    i, j = np.broadcast_arrays(velocity[:, :, None], velocity[:, None, :])
    free = (i >= 0) & (j >= 0)
    places = np.full(i.shape, indices.size, dtype=np.int32)
    places[free] = _places(indices, indptr, i[free], j[free])
    return Pattern(order, indices, indptr, places)


def _couplings(local: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices and pointers of all couplings within elements."""
    element = np.broadcast_to(np.arange(local.shape[1]), local.shape)
    free = local >= 0
    ones = np.ones(int(free.sum()), dtype=np.int8)
    incidence = csr_array((ones, (local[free], element[free])), shape=(n, local.shape[1]))
    product = csc_array(incidence @ incidence.T)
    product.sort_indices()
    return product.indices, product.indptr


def _places(
    indices: np.ndarray, indptr: np.ndarray, row: np.ndarray, column: np.ndarray
) -> np.ndarray:
    """Places of entries in the data of a csc pattern."""
    n = indptr.size - 1
    numbers = csc_array((np.arange(indices.size, dtype=float), indices, indptr), shape=(n, n))
    return np.asarray(numbers[row, column]).ravel().astype(np.int64)
