"""Near part of an H2-matrix on density functions, ``test^T G basis`` between near boxes, stored.

Sums between the points of near boxes are most of the pairs of a product. Between functions they
are a sparse matrix, several times smaller than the kernel values: computed once, box by box.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from ..near.near_field import NearField
from . import _near_block_kernels as kernels
from .cluster_tree import ClusterTree
from .point_kernel import PointKernel

CHUNK = 500_000  # values of blocks held at a time


@dataclass(frozen=True)
class LeafFunctions:
    """Functions cut at the boxes of the leaves: one item for each leaf and function in it.

    Attributes
    ----------
    n : int
        Functions.
    functions : (n_items,) int array
    item_ptr, point_ptr : (n_leaves + 1,) int array
        Items and points of each leaf.
    points : (n_points,) int array
        Points that carry a function, in tree order.
    columns : tuple of array
        Items in CSC: index pointer, places in tree order, values.
    """

    n: int
    functions: np.ndarray
    item_ptr: np.ndarray
    point_ptr: np.ndarray
    points: np.ndarray
    columns: tuple[np.ndarray, np.ndarray, np.ndarray]

    @classmethod
    def of(cls, basis: csc_matrix, tree: ClusterTree) -> LeafFunctions:
        """Cut weighted functions ``(n_points, n)``."""
        place = np.empty(tree.order.size, dtype=np.int64)
        place[tree.order] = np.arange(tree.order.size)
        ends = tree.stop[tree.leaves]
        rows = place[basis.indices]
        leaf = np.searchsorted(ends, rows, side="right")
        column = np.repeat(np.arange(basis.shape[1]), np.diff(basis.indptr))
        key = leaf * basis.shape[1] + column
        sort = np.lexsort((rows, key))
        items, first = np.unique(key[sort], return_index=True)
        points = np.unique(rows)
        bounds = np.arange(ends.size + 1)
        return cls(
            basis.shape[1],
            items % basis.shape[1],
            np.searchsorted(items // basis.shape[1], bounds),
            np.searchsorted(points, np.append(0, ends)),
            points,
            (np.append(first, rows.size), rows[sort], basis.data[sort]),
        )

    @property
    def leaves(self) -> csr_matrix:
        """Which functions are in which leaf, ``(n_leaves, n)``."""
        ones = np.ones(self.functions.size, np.int32)
        return csr_matrix((ones, self.functions, self.item_ptr), (self.item_ptr.size - 1, self.n))


def stored_near(
    kernel: PointKernel,
    tree: ClusterTree,
    pairs: np.ndarray,
    basis: csc_matrix,
    test: csc_matrix,
    dtype: type,
) -> NearField:
    """Assemble the near part.

    Parameters
    ----------
    kernel : PointKernel
    tree : ClusterTree
    pairs : (n, 2) int array
        Near pairs of leaves by number in tree order, each once for both orders.
    basis, test : csc_matrix
        Weighted functions of sources and tests, one object if they are the same.
    dtype : type
        What is stored.
    """
    sources = tests = LeafFunctions.of(basis, tree)
    mirrored = basis is test and kernel.normals is None
    turned = pairs[pairs[:, 0] != pairs[:, 1], ::-1]
    both = np.concatenate([pairs, turned])
    if basis is not test:
        tests = LeafFunctions.of(test, tree)
    n = tests.item_ptr.size - 1
    graph = csr_matrix((np.ones(both.shape[0], np.int32), both.T), (n, n))
    pattern = (tests.leaves.T.tocsr() @ graph @ sources.leaves).tocsr()
    pattern.sort_indices()
    indptr, indices = pattern.indptr.astype(np.int64), pattern.indices.astype(np.int64)
    data = np.zeros((indices.size, 6), dtype)
    pairs = pairs if mirrored else both
    for t, s, data_ptr, blocks in _blocks(kernel, tree, pairs, tests, sources, dtype):
        out = indptr, indices, data
        rows, columns = (
            ((t, tests.item_ptr, tests.functions), (s, sources.item_ptr, sources.functions))
        )  # fmt: skip
        kernels.add_to_rows(*rows, *columns, np.arange(t.size), data_ptr, blocks, False, *out)
        if mirrored:
            other = np.flatnonzero(t != s)
            other = other[np.argsort(s[other], kind="stable")]
            kernels.add_to_rows(*columns, *rows, other, data_ptr, blocks, True, *out)
    return NearField(indptr, indices, data, 0)


def _blocks(
    kernel: PointKernel,
    tree: ClusterTree,
    pairs: np.ndarray,
    tests: LeafFunctions,
    sources: LeafFunctions,
    dtype: type,
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Blocks of pairs of leaves, sorted, some at a time: t, s, index pointer, values."""
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    positions, normals = kernel.ordered(tree.order)
    sides = tests, sources
    shift = (tests.functions.size, tests.points.size, tests.columns[1].size)
    shift = (0, 0, 0) if sources is tests else shift
    once = sides[: 1 if sources is tests else 2]

    def joined(parts: list[np.ndarray], by: int) -> np.ndarray:
        return parts[0] if len(parts) == 1 else np.append(parts[0][:-1], parts[1] + by)

    item_ptr = joined([s.item_ptr for s in once], shift[0])
    point_ptr = joined([s.point_ptr for s in once], shift[1])
    points = np.concatenate([s.points for s in once])
    ptr = joined([s.columns[0] for s in once], shift[2])
    rows, values = (np.concatenate([s.columns[k] for s in once]) for k in (1, 2))
    second = 0 if sources is tests else tests.item_ptr.size - 1
    sizes = [np.diff(s.item_ptr)[p] for s, p in zip(sides, pairs.T, strict=True)]
    total = np.cumsum(6 * sizes[0] * sizes[1])
    for chunk in np.split(np.arange(total.size), np.flatnonzero(np.diff(total // CHUNK)) + 1):
        t, s = np.ascontiguousarray(pairs[chunk].T)
        data_ptr = np.append(0, np.cumsum(6 * sizes[0][chunk] * sizes[1][chunk]))
        blocks = np.empty(data_ptr[-1], dtype)
        kernels.near_blocks(
            np.arange(t.size), t, second + s, np.full(t.size, -1), item_ptr,
            np.arange(item_ptr[-1]), point_ptr, points, positions, normals, kernel.within, ptr,
            rows, values, data_ptr, blocks,
        )  # fmt: skip
        yield t, s, data_ptr, blocks
