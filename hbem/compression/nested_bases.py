"""Nested bases of an H2-matrix: which points of a cluster stand for all of it, and how.

The skeleton of a cluster are those of its points that reproduce, to the tolerance, what the
cluster does on a proxy surface around its box, inside which nothing admissible can lie; its other
charges are moved to them by an interpolation. Parents choose among the skeletons of their sons.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._threads_kernels import over
from . import _nested_basis_kernels as kernels
from .cluster_tree import BlockTree, ClusterTree
from .point_kernel import PointKernel

ETA = 1.5  # admissible if the larger diameter is at most this many distances
INSIDE = 0.95  # the proxy surface stays this far within the admissible distance


@dataclass(frozen=True)
class TreeLevel:
    """Interpolations of the nodes of one level, see `up` in the kernels."""

    starts: np.ndarray
    counts: np.ndarray
    kept: np.ndarray
    picks: np.ndarray
    pick_ptr: np.ndarray
    T_ptr: np.ndarray
    T: np.ndarray
    skeleton_ptr: np.ndarray
    leaf: bool
    nodes: np.ndarray


@dataclass(frozen=True)
class Bases:
    """Nested bases: levels from the deepest up, skeleton points by node.

    Attributes
    ----------
    ptr : (n_nodes + 1,) int array
        Skeleton of each node within ``points``.
    points : (k,) int array
        Places in tree order.
    levels : tuple of TreeLevel
        Leaves and inner nodes of a level apart.
    """

    ptr: np.ndarray
    points: np.ndarray
    levels: tuple[TreeLevel, ...]

    @property
    def nbytes(self) -> int:
        arrays = ("starts", "counts", "kept", "picks", "pick_ptr", "T_ptr", "T")
        levels = sum(getattr(level, name).nbytes for level in self.levels for name in arrays)
        return levels + self.ptr.nbytes + self.points.nbytes


def proxy_count(tolerance: float) -> int:
    """Points on a proxy surface: 80 at 1e-3, 200 at 1e-6, 330 at 1e-8."""
    digits = -np.log10(tolerance)
    return int(np.clip(40 + 4.5 * digits**2, 60, 500))


def sphere_points(n: int) -> np.ndarray:
    """Fibonacci points on the unit sphere, ``(n, 3)``."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    phi, r = np.pi * (1.0 + np.sqrt(5.0)) * k, np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def nested_bases(
    kernel: PointKernel,
    blocks: BlockTree,
    tolerance: float,
    dtype: type,
    *,
    stresslets: bool = False,
) -> Bases:
    """Skeletons and interpolations of all nodes that are, or lie below, partners of far blocks."""
    tree = blocks.tree
    needed = np.zeros(tree.n_nodes, dtype=bool)
    needed[blocks.far.ravel()] = True
    for node in range(tree.n_nodes):
        if needed[node] and tree.children[node, 0] >= 0:
            needed[tree.children[node]] = True
    positions, normals = kernel.ordered(tree.order)
    normals = normals if stresslets else np.zeros((3, 0))
    skeletons: list[np.ndarray] = [np.zeros(0, dtype=np.int64)] * tree.n_nodes
    found = []
    for depth in range(int(tree.level.max()), -1, -1):
        for leaf in (True, False):
            kind = (tree.level == depth) & needed & ((tree.children[:, 0] < 0) == leaf)
            nodes = np.flatnonzero(kind)
            if nodes.size:
                more = (positions, normals, skeletons, tolerance, dtype)
                found.append(_level(tree, nodes, leaf, *more))
    ptr = np.concatenate([[0], np.cumsum([s.size for s in skeletons])])
    levels = tuple(_place_level(tree, ptr, level) for level in found)
    return Bases(ptr, np.concatenate(skeletons), levels)


def _level(
    tree: ClusterTree,
    nodes: np.ndarray,
    leaf: bool,
    positions: np.ndarray,
    normals: np.ndarray,
    skeletons: list[np.ndarray],
    tolerance: float,
    dtype: type,
) -> TreeLevel:
    """Skeletons of some nodes; ``skeletons`` receives their points."""
    if leaf:
        lists = [np.arange(tree.start[k], tree.stop[k]) for k in nodes]
    else:
        lists = [np.concatenate([skeletons[a], skeletons[b]]) for a, b in tree.children[nodes]]
    counts = np.array([c.size for c in lists])
    ptr = np.concatenate([[0], np.cumsum(counts)])
    candidates = np.concatenate(lists)
    slot_ptr = np.concatenate([[0], np.cumsum(9 * counts**2 // 4 + 1)])
    slots = np.empty(slot_ptr[-1], dtype=dtype)
    kept, picks = np.empty(nodes.size, dtype=np.int64), np.empty(ptr[-1], dtype=np.int64)
    over(
        len(nodes), kernels.level_skeletons, tree.lower[nodes], tree.upper[nodes],
        sphere_points(proxy_count(tolerance)), INSIDE / ETA, positions, ptr, candidates, tolerance,
        kept, picks, slot_ptr, slots, normals,
    )  # fmt: skip
    for i, node in enumerate(nodes):
        skeletons[node] = lists[i][picks[ptr[i] : ptr[i] + kept[i]]]
    sizes = 9 * kept * (counts - kept)
    T = np.concatenate([slots[a : a + n] for a, n in zip(slot_ptr, sizes, strict=False)])
    T_ptr = np.concatenate([[0], np.cumsum(sizes)])
    none, picks = np.zeros(0, dtype=np.int64), picks.astype(np.int32)
    return TreeLevel(none, counts, kept, picks, ptr, T_ptr, T, none, leaf, nodes)


def _place_level(tree: ClusterTree, ptr: np.ndarray, level: TreeLevel) -> TreeLevel:
    """A level with the places of its candidates and skeletons."""
    nodes = level.nodes
    starts = tree.start[nodes] if level.leaf else ptr[tree.children[nodes, 0]]
    return replace(level, starts=starts, skeleton_ptr=ptr[nodes])
