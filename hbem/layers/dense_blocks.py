"""Exact dense blocks of a single layer that is not stored: plain far part plus near entries.

``A[p, p] = (B^T W G W B)[p, p] + N[p, p]`` for some density functions p: the subdomain matrices of
a Schwarz preconditioner, or all functions. Entries that several blocks share are computed once.
Rough subdomain matrices (one point an element) triple the iterations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.sparse import csr_matrix

from .._threads_kernels import workers
from ..near.near_field import NearField, table_values
from ..near.near_rules import coincident_distance_squared
from ..surfaces.surface_points import SampledSurface
from . import _plain_block_kernels as kernels

Consume = Callable[[int, np.ndarray], np.ndarray]  # number of a subdomain and its block
SHARED_BYTES = 1e9  # blocks of subdomains that share entries; these take a third of it
Entries = tuple[np.ndarray, np.ndarray, np.ndarray]  # of a CSR matrix, data (nnz, 6)
AHEAD = 64  # sweeps whose sums may wait for their turn


def vector_dofs(functions: np.ndarray) -> np.ndarray:
    """Vector dofs ``3 a + i`` of scalar functions, ``(3 n,)``."""
    return (3 * functions[:, None] + np.arange(3)).ravel()


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

    def all(self) -> np.ndarray:
        """The block of all density functions, ``(3 n, 3 n)``."""
        return self.map_blocks([np.arange(self.near.n_dofs)], lambda k, block: block)[0]

    def map_blocks(self, subdomains: Sequence[np.ndarray], consume: Consume) -> list[np.ndarray]:
        """``consume(k, block)`` of every subdomain, on all threads; the block is then freed."""
        done: list[np.ndarray] = []
        with workers() as pool:
            for group in _groups(subdomains):
                one = partial(self._consumed, consume, self._plain(subdomains[group], pool))
                done += pool.map(one, range(group.start, group.stop), subdomains[group])
        return done

    def _consumed(
        self, consume: Consume, plain: Entries, k: int, functions: np.ndarray
    ) -> np.ndarray:
        near, block = self.near, np.zeros((3 * functions.size,) * 2)
        same = self.surface.source is self.surface.outer
        kernels.add_block(functions, *plain, same, block)
        kernels.add_block(functions, near.indptr, near.indices, near.data, False, block)
        return consume(k, block)

    def _plain(self, subdomains: Sequence[np.ndarray], pool: Executor) -> Entries:
        """Plain entries between all functions that share a subdomain, each computed once.

        With equal outer and source points they are S of ``S + S^T``.
        """
        carriers, n = self._carriers, self.surface.outer.weights.size
        member = _incidence(subdomains, self.near.n_dofs)
        pattern = member.T.tocsr() @ member
        indptr, indices = pattern.indptr.astype(np.int64), pattern.indices.astype(np.int64)
        starts = np.arange(0, n, kernels.LANES)
        sweeps = csr_matrix(
            (np.ones(n), np.arange(n), np.append(starts, n)), shape=(starts.size, n)
        )
        around = sweeps @ self.surface.basis.astype(bool) @ member.T
        elements, functions = around @ (member @ carriers), around @ member
        elements.sort_indices()
        data = np.zeros((indices.size, 6))

        tested: Callable[..., Entries] = kernels.tested_sums

        def sums(i: int) -> Entries:
            return tested(*self._inputs, starts[i], _row(elements, i), _row(functions, i))

        active = np.flatnonzero(np.diff(around.indptr))
        for ahead in np.split(active, np.arange(AHEAD, active.size, AHEAD)):
            for found in pool.map(sums, ahead):
                kernels.add_sums(*found, indptr, indices, data)
        return indptr, indices, data

    @cached_property
    def _inputs(self) -> tuple:
        """Targets, their functions, sources and theirs, as the kernel takes them."""
        s = self.surface
        outer, source, p, basis = s.outer, s.source, s.patches, s.basis
        return (
            outer.offsets,
            outer.weights,
            basis.indptr.astype(np.int64),
            basis.indices.astype(np.int64),
            basis.data,
            source.offsets.reshape(p.n_elements, -1, 3),
            source.weights.reshape(p.n_elements, -1),
            np.ascontiguousarray(table_values(s, source)),
            np.ascontiguousarray(p.indptr, dtype=np.int64),
            np.ascontiguousarray(p.dofs, dtype=np.int64),
            p.n_dofs,
            source is outer,
            coincident_distance_squared(s),
        )

    @cached_property
    def _carriers(self) -> csr_matrix:
        """Elements of each density function, ``(n_dofs, n_elements)``."""
        p = self.surface.patches
        shape = (p.n_elements, p.n_dofs)
        return csr_matrix((np.ones(p.dofs.size), p.dofs, p.indptr), shape=shape).T.tocsr()


def _incidence(sets: Sequence[np.ndarray], n: int) -> csr_matrix:
    """One row a set, ones at its members."""
    indptr = np.append(0, np.cumsum([s.size for s in sets]))
    return csr_matrix((np.ones(indptr[-1]), np.concatenate(sets), indptr), shape=(len(sets), n))


def _row(matrix: csr_matrix, i: int) -> np.ndarray:
    return matrix.indices[matrix.indptr[i] : matrix.indptr[i + 1]].astype(np.int64)


def _groups(subdomains: Sequence[np.ndarray]) -> list[slice]:
    """Ranges of subdomains whose blocks together fit in `SHARED_BYTES`, at least one each."""
    part = np.cumsum([48.0 * s.size**2 for s in subdomains]) // SHARED_BYTES
    starts = np.flatnonzero(np.diff(part, prepend=-1.0))
    return [slice(a, b) for a, b in zip(starts, [*starts[1:], len(subdomains)], strict=True)]
