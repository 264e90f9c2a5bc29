"""Adaptive cross approximation of all admissible blocks, in parallel, never silent.

Every block is accepted on proof only (sampled rows, see the kernels), recompressed, and reported
with rank -1 where compression does not pay: it then belongs to the near field. Entries are those
of the plain point kernel; blocks are projected to density functions before recompression, so
that storage is by dof and no Galerkin entry is evaluated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix

from .._threads_kernels import workers
from ._recompression_kernels import compress_blocks
from .cluster_tree import ClusterTree, cluster_tree
from .point_kernel import PointKernel

# Tolerances of cross approximation and recompression in units of the requested one. Between points
# the exact near field dilutes the error by two or three, between functions less.
CROSS = {"points": 0.4, "functions": 0.33}
KEPT = {"points": 1.2, "functions": 0.8}
TASK = 64  # blocks of one task


@dataclass(frozen=True)
class ClusterPoints:
    """Items and support points of the nodes of a tree, node after node.

    Attributes
    ----------
    item_ptr, items : (n_nodes + 1,), (k,) int array
    point_ptr, points : (n_nodes + 1,), (k,) int array
        The same as the items where items are points.
    basis : csc_matrix or None
        Weighted functions ``(n_points, n_items)``.
    """

    item_ptr: np.ndarray
    items: np.ndarray
    point_ptr: np.ndarray
    points: np.ndarray
    basis: csc_matrix | None = None

    @property
    def columns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Index pointer, points and values of the weighted functions."""
        if self.basis is None:
            none = np.zeros(0, dtype=np.int64)
            return none, none, np.zeros(0)
        b = self.basis
        return b.indptr.astype(np.int64), b.indices.astype(np.int64), b.data


def item_tree(points: np.ndarray, basis: csc_matrix | None, leaf: int) -> ClusterTree:
    """Tree over points ``(n, 3)``, or over functions with the boxes of their supports."""
    if basis is None:
        return cluster_tree(points, leaf=leaf)
    positions = points[basis.indices]
    starts = basis.indptr[:-1]
    lower, upper = (f.reduceat(positions, starts) for f in (np.minimum, np.maximum))
    return cluster_tree(lower, upper, leaf=leaf)


def cluster_points(tree: ClusterTree, basis: csc_matrix | None = None) -> ClusterPoints:
    """Items and, for functions, the points of their supports (increasing) of every node."""
    item_ptr = np.concatenate([[0], np.cumsum(tree.sizes)])
    items = [tree.order[a:b] for a, b in zip(tree.start, tree.stop, strict=True)]
    flat = np.concatenate(items)
    if basis is None:
        return ClusterPoints(item_ptr, flat, item_ptr, flat)
    mark = np.zeros(basis.shape[0], dtype=bool)
    points = []
    for members in items:
        support = _rows(basis, members)
        mark[support] = True
        points.append(np.flatnonzero(mark) if support.size * 20 > mark.size else np.unique(support))
        mark[support] = False
    point_ptr = np.concatenate([[0], np.cumsum([p.size for p in points])])
    return ClusterPoints(item_ptr, flat, point_ptr, np.concatenate(points), basis)


def _rows(basis: csc_matrix, columns: np.ndarray) -> np.ndarray:
    counts = basis.indptr[columns + 1] - basis.indptr[columns]
    starts = np.repeat(basis.indptr[columns] - np.cumsum(counts) + counts, counts)
    return basis.indices[starts + np.arange(counts.sum())]


@dataclass(frozen=True)
class Factors:
    """Low-rank factors of consecutive blocks: ranks (-1: full) and their rows one by one."""

    blocks: np.ndarray
    ranks: np.ndarray
    store: np.ndarray


def approximate_blocks(
    blocks: np.ndarray,
    clusters: ClusterPoints,
    kernel: PointKernel,
    *,
    tolerance: float,
    full_rank: float,
    dtype: type,
    seed: int = 0,
) -> Iterator[Factors]:
    """Factors of all blocks ``(n, 2)`` in order, each relative to its own Frobenius norm.

    Parameters
    ----------
    blocks : (n, 2) int array
    clusters : ClusterPoints
    kernel : PointKernel
    full_rank : float
        Ranks above this share of ``m n / (m + n)`` do not pay: the block is left full.
    """
    kind = "points" if clusters.basis is None else "functions"
    tolerances = tolerance * np.array([CROSS[kind], KEPT[kind]])
    columns = clusters.columns

    def work(first: int) -> Factors:
        part = blocks[first : first + TASK]
        numbers = seed * 1_000_003 + first + np.arange(part.shape[0])
        # of this task alone: tasks run side by side
        scratch: np.ndarray = np.empty(1 << 14, dtype=dtype)
        ranks, store = compress_blocks(
            part, numbers, kernel.scaled, kernel.scaled_normals, kernel.within, clusters.item_ptr,
            clusters.items, clusters.point_ptr, clusters.points, *columns, tolerances,
            full_rank, scratch,
        )  # fmt: skip
        return Factors(part, ranks, store)

    starts = range(0, blocks.shape[0], TASK)
    with workers() as pool:
        yield from pool.map(work, starts)
