"""The far field of an H-matrix as one dense panel a leaf.

A block ``A_ts ~ U V^T`` leaves its factors with the clusters t and s; the panel of a leaf holds
the rows of the factors of the leaf and all its ancestors side by side. A product is then two
sweeps over equal dense panels, free of conflicts. The symmetric single layer needs each block
once, ``A_st = V U^T``, and one set of panels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._threads_kernels import over
from . import _far_field_kernels as kernels
from .cluster_tree import ClusterTree
from .cross_approximation import Factors


@dataclass(frozen=True)
class Panels:
    """Panels of all leaves, rows in tree order, components first."""

    leaf_ptr: np.ndarray
    width: np.ndarray
    panel_ptr: np.ndarray
    z_ptr: np.ndarray
    base: np.ndarray
    values: np.ndarray

    @property
    def n_values(self) -> int:
        """Length of z: one value a panel column."""
        return int(self.z_ptr[-1])


@dataclass(frozen=True)
class FarField:
    """Low-rank blocks of a matrix, ready for products.

    Attributes
    ----------
    left, right : Panels
        Factors on the side of the targets and of the sources; one object if symmetric.
    sources, source_ptr, slots, slot_ptr, lengths :
        The exchange between both sides of all factors, see `exchange` in the kernels.
    ranks : (n_blocks,) int array
    """

    left: Panels
    right: Panels
    sources: np.ndarray
    source_ptr: np.ndarray
    slots: np.ndarray
    slot_ptr: np.ndarray
    lengths: np.ndarray
    ranks: np.ndarray

    @property
    def nbytes(self) -> int:
        panels = {id(p): p.values.nbytes for p in (self.left, self.right)}
        return sum(panels.values()) + self.sources.nbytes + self.slots.nbytes

    @property
    def dtype(self) -> np.dtype:
        return self.left.values.dtype

    def add_product(self, x: np.ndarray, y: np.ndarray) -> None:
        """``y += A_far x`` for ``x, y (k, 3, n)`` in tree order, of one precision."""
        a, b = self.left, self.right
        if a.n_values == 0:
            return
        z = np.empty((x.shape[0], b.n_values), dtype=x.dtype)
        z_in = np.zeros((x.shape[0], a.n_values), dtype=x.dtype)
        over(
            b.width.size, kernels.gather, b.panel_ptr, b.width, b.leaf_ptr, b.values, x, b.z_ptr, z
        )
        slots = self.slot_ptr, self.slots
        over(
            self.lengths.size, kernels.exchange, z, self.sources, self.source_ptr, self.lengths,
            z_in, *slots,
        )  # fmt: skip
        over(
            a.width.size, kernels.scatter, a.panel_ptr, a.width, a.leaf_ptr, a.values, a.z_ptr,
            z_in, y,
        )  # fmt: skip


def leaf_ranges(tree: ClusterTree) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First and last leaf of every node, and the index pointer of leaves to items."""
    leaves = tree.leaves
    leaf_ptr = np.append(tree.start[leaves], tree.order.size)
    first = np.searchsorted(leaf_ptr, tree.start)
    last = np.searchsorted(leaf_ptr, tree.stop) - 1
    return first, last, leaf_ptr


def leaf_pairs(blocks: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """All pairs of leaves below pairs of nodes."""
    parts = [np.zeros((0, 2), dtype=np.int64)]
    for t, s in blocks:
        a, b = np.arange(first[t], last[t] + 1), np.arange(first[s], last[s] + 1)
        parts.append(np.stack([np.repeat(a, b.size), np.tile(b, a.size)], axis=1))
    return np.concatenate(parts)


def far_field(tree: ClusterTree, parts: list[Factors], *, symmetric: bool, dtype: type) -> FarField:
    """Arrange the factors of all blocks in panels; the parts are emptied on the way."""
    blocks = np.concatenate([p.blocks for p in parts] or [np.zeros((0, 2), dtype=np.int64)])
    ranks = np.concatenate([p.ranks for p in parts] or [np.zeros(0, dtype=np.int64)])
    stored = np.maximum(ranks, 0)
    first, last, leaf_ptr = leaf_ranges(tree)
    if symmetric:
        sides = _columns(np.concatenate([blocks[:, 0], blocks[:, 1]]), np.tile(stored, 2), tree)
        offsets = sides[0].reshape(2, -1)
        left = right = _panels(tree, sides[1], leaf_ptr, dtype)
    else:
        (a, width_a), (b, width_b) = (_columns(blocks[:, k], stored, tree) for k in range(2))
        offsets = np.stack([a, b])
        left = _panels(tree, width_a, leaf_ptr, dtype)
        right = _panels(tree, width_b, leaf_ptr, dtype)
    done = 0
    while parts:
        part = parts.pop(0)  # freed: panels and factors together would double the peak
        here = slice(done, done + part.ranks.size)
        kernels.fill(
            part.blocks, part.ranks, part.store, offsets[0, here], offsets[1, here],
            left.base, right.base, first, last, leaf_ptr, left.width, right.width,
            left.panel_ptr, right.panel_ptr, left.values, right.values,
        )  # fmt: skip
        done += part.ranks.size
    used = np.flatnonzero(stored)
    at_left = _places(blocks[used, 0], offsets[0, used], left, first, last)
    at_right = _places(blocks[used, 1], offsets[1, used], right, first, last)
    lengths = stored[used]
    if symmetric:
        sources, slots = _join(at_right, at_left), _join(at_left, at_right)
        lengths = np.tile(lengths, 2)
    else:
        sources, slots = at_right, at_left
    return FarField(left, right, sources[1], sources[0], slots[1], slots[0], lengths, ranks)


def _columns(
    nodes: np.ndarray, ranks: np.ndarray, tree: ClusterTree
) -> tuple[np.ndarray, np.ndarray]:
    """Column of every factor within its node, and the number of columns of every node."""
    order = np.argsort(nodes, kind="stable")
    ends = np.cumsum(ranks[order])
    before = ends - ranks[order]
    width = np.bincount(nodes, weights=ranks, minlength=tree.n_nodes).astype(np.int64)
    starts = np.concatenate([[0], np.cumsum(width)])[:-1]
    columns = np.empty_like(ranks)
    columns[order] = before - starts[nodes[order]]
    return columns, width


def _panels(tree: ClusterTree, columns: np.ndarray, leaf_ptr: np.ndarray, dtype: type) -> Panels:
    base = np.zeros(tree.n_nodes, dtype=np.int64)
    for node in range(tree.n_nodes):
        if tree.children[node, 0] >= 0:
            base[tree.children[node]] = base[node] + columns[node]
    leaves = tree.leaves
    width = -(-(base[leaves] + columns[leaves]) // kernels.FOLD) * kernels.FOLD
    sizes = 3 * np.diff(leaf_ptr) * width
    panel_ptr = np.concatenate([[0], np.cumsum(sizes)])
    z_ptr = np.concatenate([[0], np.cumsum(width)])
    return Panels(leaf_ptr, width, panel_ptr, z_ptr, base, np.zeros(panel_ptr[-1], dtype=dtype))


def _places(
    nodes: np.ndarray, columns: np.ndarray, panels: Panels, first: np.ndarray, last: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where the columns of factors stand in z, leaf by leaf: index pointer and places."""
    counts = last[nodes] + 1 - first[nodes]
    ptr = np.concatenate([[0], np.cumsum(counts)])
    leaf = np.arange(ptr[-1]) - np.repeat(ptr[:-1] - first[nodes], counts)
    return ptr, panels.z_ptr[leaf] + np.repeat(panels.base[nodes] + columns, counts)


def _join(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> tuple:
    return np.concatenate([a[0], a[0][-1] + b[0][1:]]), np.concatenate([a[1], b[1]])
