"""Near field on density dofs, ``B^T W C_near`` in block CSR, assembled without a dense matrix.

C_near is what the plain point rule misses at near (outer point, element) pairs [T 3.10a]. The
kernel is symmetric in its two indices, so a block of test and density function keeps the six
components 00 01 02 11 12 22. The far part that it completes is ``B^T W G W B``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix

from .._threads_kernels import over
from ..surfaces.bernstein import tensor_bernstein
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import PointSet, SampledSurface
from . import _near_field_kernels as kernels
from .closest_point import NearPairs, outer_pairs
from .near_rules import near_moments

# moments, and blocks of pairs of elements, held at a time: shorter ones make threads wait
CHUNK_BYTES, BLOCK_BYTES = 64e6, 8e6
FULL = np.array([0, 1, 2, 1, 3, 4, 2, 4, 5])  # six components to a 3x3 block


@dataclass(frozen=True)
class NearField:
    """Sparse near field of an integral operator on density dofs.

    Attributes
    ----------
    indptr : (n_dofs + 1,) int array
    indices : (nnz,) int array
        Density functions of each test function's row, increasing.
    data : (nnz, 6) array
        Symmetric blocks, components 00 01 02 11 12 22.
    n_pairs : int
        Near (outer point, element) pairs behind them.
    """

    indptr: np.ndarray
    indices: np.ndarray
    data: np.ndarray
    n_pairs: int

    @property
    def n_dofs(self) -> int:
        return self.indptr.size - 1

    @property
    def nbytes(self) -> int:
        return self.indptr.nbytes + self.indices.nbytes + self.data.nbytes

    def apply(self, x: np.ndarray) -> np.ndarray:
        """Product with densities ``(n_dofs, 3, k)``, threaded."""
        x = np.ascontiguousarray(x)
        y = np.zeros(x.shape)
        over(len(y), kernels.multiply, self.indptr, self.indices, self.data, x, y)
        return y

    def apply_transposed(self, x: np.ndarray) -> np.ndarray:
        """Transposed product with densities ``(n_dofs, 3, k)``."""
        return (self.matrix().T @ x.reshape(-1, x.shape[2])).reshape(x.shape)

    def transposed(self) -> NearField:
        """The same with test and density functions exchanged."""
        place = np.arange(self.indices.size)
        turned = csr_matrix((place, self.indices, self.indptr), (self.n_dofs,) * 2).T.tocsr()
        return NearField(turned.indptr, turned.indices, self.data[turned.data], self.n_pairs)

    def matrix(self) -> bsr_matrix:
        """The same as scipy matrix ``(3 n_dofs, 3 n_dofs)`` of 3x3 blocks, a copy."""
        blocks = self.data[:, FULL].reshape(-1, 3, 3)
        return bsr_matrix((blocks, self.indices, self.indptr), shape=(3 * self.n_dofs,) * 2)

    def components(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Dense part ``(len(rows), len(columns), 6)`` for some test and density functions."""
        position = np.full(self.n_dofs, -1)
        position[columns] = np.arange(columns.size)
        out = np.zeros((rows.size, columns.size, 6))
        for i, a in enumerate(rows):
            line = slice(self.indptr[a], self.indptr[a + 1])
            at = position[self.indices[line]]
            out[i, at[at >= 0]] = self.data[line][at >= 0]
        return out


def near_field(surface: SampledSurface, orders: QuadratureOrders) -> NearField:
    """Assemble the near field of the single layer."""
    n = surface.outer.weights.size
    pairs = outer_pairs(surface, orders, slice(0, n))
    return assemble(
        surface, pairs, lambda part: near_moments(surface, part, orders, minus_plain=True)
    )


def assemble(
    surface: SampledSurface, pairs: NearPairs, moments: Callable[[NearPairs], np.ndarray]
) -> NearField:
    """Test the moments of near pairs with the density functions.

    Parameters
    ----------
    surface : SampledSurface
    pairs : NearPairs
        Near pairs of all outer points.
    moments : callable
        ``NearPairs`` of some points to their ``(n_pairs, nb, 6)`` moments; called chunk by chunk.
    """
    patches, nt = surface.patches, surface.outer.per_element
    touching = _element_pairs(surface, pairs)
    indptr, indices = _pattern(surface, touching)
    data = np.zeros((indices.size, 6))
    owner_indptr, owners = _owners(surface)
    table_indptr = np.ascontiguousarray(patches.indptr, dtype=np.int64)
    dofs = np.ascontiguousarray(patches.dofs, dtype=np.int64)
    extraction = np.ascontiguousarray(patches.extraction, dtype=float)
    values = table_values(surface, surface.outer)
    weights = surface.outer.weights.reshape(-1, nt)
    sizes = np.diff(table_indptr)
    near_rows = np.append(0, np.cumsum(sizes[touching.indices]))[touching.indptr]
    shares = 48.0 * np.cumsum(sizes * np.diff(near_rows))
    for first, last in _chunks(pairs.indptr[nt::nt] * (48.0 * extraction.shape[1]), CHUNK_BYTES):
        part = pairs.part(slice(first * nt, last * nt))
        found = moments(part).reshape(part.n_pairs, -1)
        for low, high in _chunks(shares[first:last], BLOCK_BYTES, first):
            sources_indptr = touching.indptr[low : high + 1] - touching.indptr[low]
            sources = touching.indices[touching.indptr[low] : touching.indptr[high]]
            ends = np.cumsum(np.repeat(sizes[low:high], np.diff(sources_indptr)) * sizes[sources])
            places, blocks = np.append(0, ends), np.empty((ends[-1], 6))
            over(
                high - low, kernels.test_moments, low, values, weights, table_indptr, extraction,
                part.indptr[(low - first) * nt :], part.elements, found, sources_indptr, sources,
                places, blocks,
            )  # fmt: skip
            rows = np.unique(dofs[table_indptr[low] : table_indptr[high]])
            over(
                rows.size, kernels.add_rows, rows, owner_indptr, owners, low, high, table_indptr,
                dofs, sources_indptr, sources, places, blocks, indptr, indices, data,
            )  # fmt: skip
    return NearField(indptr, indices, data, pairs.n_pairs)


def table_values(surface: SampledSurface, points: PointSet) -> np.ndarray:
    """Density functions at local points by table row, ``(n_rows, per_element)``."""
    patches = surface.patches
    return patches.extraction @ tensor_bernstein(patches.density_degree, points.s, points.t).T


def _chunks(ends: np.ndarray, size: float, first: int = 0) -> list[tuple[int, int]]:
    """Ranges of elements, from ``first``, of about ``size`` bytes each; ``ends`` adds them up."""
    part = np.floor_divide(ends, size)
    starts = first + np.flatnonzero(np.diff(part, prepend=-1))
    return list(zip(starts, [*starts[1:], first + part.size], strict=True))


def _element_pairs(surface: SampledSurface, pairs: NearPairs) -> csr_matrix:
    """Source elements near any point of each target element, sorted."""
    n = surface.patches.n_elements
    counts = np.diff(pairs.indptr[:: surface.outer.per_element])
    keys = np.unique(np.repeat(np.arange(n), counts) * n + pairs.elements)
    e, f = np.divmod(keys, n)
    indptr = np.searchsorted(e, np.arange(n + 1))
    return csr_matrix((np.ones(f.size, np.int32), f, indptr), shape=(n, n))


def _pattern(surface: SampledSurface, touching: csr_matrix) -> tuple[np.ndarray, np.ndarray]:
    """Test and density functions that meet in a near pair: CSR indices."""
    p = surface.patches
    ones = np.ones(p.dofs.size, np.int32)
    support = csr_matrix((ones, p.dofs, p.indptr), shape=(p.n_elements, p.n_dofs))
    pattern = (support.T.tocsr() @ touching @ support).tocsr()
    pattern.sort_indices()
    return pattern.indptr.astype(np.int64), pattern.indices.astype(np.int64)


def _owners(surface: SampledSurface) -> tuple[np.ndarray, np.ndarray]:
    """Table rows of each density function: index pointer, ``(element, row)`` pairs."""
    p = surface.patches
    rows = np.argsort(p.dofs, kind="stable")
    element = np.repeat(np.arange(p.n_elements), np.diff(p.indptr))
    indptr = np.searchsorted(p.dofs[rows], np.arange(p.n_dofs + 1))
    return indptr, np.ascontiguousarray(np.stack([element[rows], rows], axis=1))
