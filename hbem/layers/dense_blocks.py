"""Exact dense blocks of a single layer that is not stored: plain far part plus near entries.

``A[p, p] = (B^T W G W B)[p, p] + N[p, p]`` for a few hundred density functions p, the
subdomain matrices of a Schwarz preconditioner. Rough ones (one point an element) triple its
iterations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from .._threads_kernels import workers
from ..near.near_field import NearField, table_values
from ..near.near_rules import coincident_distance_squared
from ..surfaces.surface_points import SampledSurface
from . import _dense_block_kernels as kernels

Consume = Callable[[int, np.ndarray], np.ndarray]  # number of a subdomain and its block
COMPONENTS = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


def vector_dofs(functions: np.ndarray) -> np.ndarray:
    """Vector dofs ``3 a + i`` of scalar functions, ``(3 n,)``."""
    return (3 * functions[:, None] + np.arange(3)).ravel()


def interleave(components: np.ndarray) -> np.ndarray:
    """Six components ``(n, m, 6)`` as a matrix ``(3 n, 3 m)`` on vector dofs."""
    n, m = components.shape[:2]
    return np.swapaxes(components[:, :, COMPONENTS], 1, 2).reshape(3 * n, 3 * m)


@dataclass(frozen=True)
class DensityTables:
    """Density functions of a surface in the layout of the kernels, by table row."""

    surface: SampledSurface

    @cached_property
    def outer_values(self) -> np.ndarray:
        return table_values(self.surface, self.surface.outer)

    @cached_property
    def source_values(self) -> np.ndarray:
        same = self.surface.source is self.surface.outer
        return self.outer_values if same else table_values(self.surface, self.surface.source)

    @cached_property
    def indptr(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.indptr, dtype=np.int64)

    @cached_property
    def dofs(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.dofs, dtype=np.int64)


@dataclass(frozen=True)
class ExactBlocks:
    """Blocks of one operator.

    Parameters
    ----------
    surface : SampledSurface
    near : NearField
    """

    surface: SampledSurface
    near: NearField

    def __call__(self, functions: np.ndarray) -> np.ndarray:
        """The block ``(3 n, 3 n)`` of some density functions."""
        p, outer, source = self.surface.patches, self.surface.outer, self.surface.source
        position = np.full(p.n_dofs, -1)
        position[functions] = np.arange(functions.size)
        elements = np.unique(self._carriers[functions].indices).astype(np.int64)
        block = np.zeros((functions.size, functions.size, 6))
        kernels.plain_block(
            elements,
            self._targets,
            outer.weights.reshape(p.n_elements, -1),
            self._tables.outer_values,
            source.offsets.reshape(p.n_elements, -1, 3),
            source.weights.reshape(p.n_elements, -1),
            self._tables.source_values,
            self._tables.indptr,
            position[p.dofs],
            source is outer,
            coincident_distance_squared(self.surface),
            block,
        )
        return interleave(block + self.near.components(functions, functions))

    def map_blocks(self, subdomains: Sequence[np.ndarray], consume: Consume) -> list[np.ndarray]:
        """``consume(k, block)`` of every subdomain, on all threads; the block is then freed."""
        tables = self._tables
        _ = tables.outer_values, tables.source_values, tables.indptr, self._carriers, self._targets
        with workers() as pool:
            count = range(len(subdomains))
            return list(pool.map(lambda k: consume(k, self(subdomains[k])), count))

    @cached_property
    def _tables(self) -> DensityTables:
        return DensityTables(self.surface)

    @cached_property
    def _carriers(self) -> csr_matrix:
        """Elements of each density function."""
        p = self.surface.patches
        ones = np.ones(p.dofs.size)
        shape = (p.n_elements, p.n_dofs)
        return csr_matrix((ones, p.dofs, p.indptr), shape=shape).T.tocsr()

    @cached_property
    def _targets(self) -> np.ndarray:
        n = self.surface.patches.n_elements
        points = self.surface.outer.offsets.reshape(n, -1, 3)
        return np.ascontiguousarray(np.swapaxes(points, 1, 2))
