"""Near part of an H2-matrix on density functions, ``test^T G basis`` between near boxes, stored.

Sums between the points of near boxes are most of the pairs of a product. Between functions they
are a sparse matrix, far smaller than the kernel values: computed once, box by box.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from threadpoolctl import threadpool_limits

from ..._threads_kernels import over
from ...near.near_field import NearField
from ..cluster_tree import ClusterTree
from ..point_kernel import PointKernel
from . import _strip_kernels as kernels

CHUNK = 4_000_000  # values of strips held at a time


@dataclass(frozen=True)
class LeafFunctions:
    """Functions cut at the boxes of the leaves: an item for each leaf and function in it.

    Attributes
    ----------
    point_ptr, points :
        Points of each leaf that carry a function, by place in tree order.
    item_ptr, items :
        Functions of each leaf, increasing.
    dense_ptr, dense :
        Their values at its points, ``(n_points, n_items)`` a leaf.
    """

    point_ptr: np.ndarray
    points: np.ndarray
    item_ptr: np.ndarray
    items: np.ndarray
    dense_ptr: np.ndarray
    dense: np.ndarray

    @classmethod
    def of(cls, functions: csc_matrix, tree: ClusterTree, dtype: type) -> LeafFunctions:
        """Cut weighted functions ``(n_points, n)``."""
        place = np.empty(tree.order.size, dtype=np.int64)
        place[tree.order] = np.arange(tree.order.size)
        ends, n = tree.stop[tree.leaves], functions.shape[1]
        rows = place[functions.indices]
        leaf = np.searchsorted(ends, rows, side="right")
        column = np.repeat(np.arange(n), np.diff(functions.indptr))
        points, point = np.unique(rows, return_inverse=True)
        keys, item = np.unique(leaf * n + column, return_inverse=True)
        point_ptr = np.searchsorted(points, np.append(0, ends))
        item_ptr = np.searchsorted(keys // n, np.arange(ends.size + 1))
        widths = np.diff(item_ptr)
        dense_ptr = np.append(0, np.cumsum(np.diff(point_ptr) * widths))
        dense = np.zeros(dense_ptr[-1], dtype)
        at = (point - point_ptr[leaf]) * widths[leaf] + item - item_ptr[leaf]
        dense[dense_ptr[leaf] + at] = functions.data
        return cls(point_ptr, points, item_ptr, keys % n, dense_ptr, dense)

    def matrix(self, n: int) -> csr_matrix:
        """Which of n functions are in which leaf, ``(n_leaves, n)``."""
        ones = np.ones(self.items.size, np.int32)
        return csr_matrix((ones, self.items, self.item_ptr), (self.item_ptr.size - 1, n))


def stored_near(
    kernel: PointKernel,
    tree: ClusterTree,
    pairs: np.ndarray,
    basis: csc_matrix,
    test: csc_matrix,
    dtype: type,
    room: float | None = None,
) -> NearField | None:
    """Assemble the near part; None where it would take more than ``room`` bytes.

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
    room : float, optional
    """
    n, leaves = basis.shape[1], tree.leaves.size
    sources = tests = LeafFunctions.of(basis, tree, dtype)
    if basis is not test:
        tests = LeafFunctions.of(test, tree, dtype)
    graph = csr_matrix((np.ones(pairs.shape[0], np.int32), pairs.T), (leaves, leaves))
    both = graph + graph.T
    pattern = (tests.matrix(n).T.tocsr() @ both @ sources.matrix(n)).tocsr()
    pattern.sort_indices()
    indptr, indices = pattern.indptr, pattern.indices
    if (
        room is not None
        and indptr.nbytes + indices.nbytes + 6 * np.dtype(dtype).itemsize * indices.size > room
    ):
        return None
    halved = basis is test and kernel.normals is None  # the other half is the transposed one
    graph = graph if halved else both.tocsr()
    strips = (graph @ sources.matrix(n)).tocsr()
    strips.sort_indices()
    sizes = 6 * np.diff(strips.indptr).astype(np.int64) * np.diff(tests.item_ptr)
    ends, data = np.cumsum(sizes), np.zeros((indices.size, 6), dtype)
    cuts = np.flatnonzero(np.diff(ends // CHUNK)) + 1
    positions, normals = kernel.ordered(tree.order)
    t, s = tests, sources
    with threadpool_limits(1, "blas"):
        for begin, end in zip([0, *cuts], [*cuts, leaves], strict=True):
            at = ends[begin:end] - sizes[begin:end]
            at -= at[0]
            part = np.empty(at[-1] + sizes[end - 1], dtype)
            over(
                end - begin, kernels.near_strips, begin, positions, normals, kernel.within,
                t.point_ptr, t.points, t.item_ptr, t.dense_ptr, t.dense,
                s.point_ptr, s.points, s.item_ptr, s.items, s.dense_ptr, s.dense,
                graph.indptr, graph.indices, halved, strips.indptr, strips.indices, at, part,
            )  # fmt: skip
            kernels.add_strips(
                begin, end, t.item_ptr, t.items, strips.indptr, strips.indices, at, part,
                indptr, indices, data,
            )  # fmt: skip
    if halved:
        kernels.add_transposed(indptr, indices, data)
    return NearField(indptr, indices, data, 0)
