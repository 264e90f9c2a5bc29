"""H2-matrix of a plain Stokes kernel: nested bases from skeletons, coupling on the fly.

The charges of a cluster are replaced by equivalent ones on a few of its points, level by level
upwards; clusters far from each other exchange the exact kernel between skeletons; potentials go
down by the transposed interpolations. Only the interpolations are stored. Skeletons come from a
proxy surface around the box of the cluster, inside which nothing admissible can lie.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix, spmatrix

from . import _nested_basis_kernels as kernels
from .cluster_tree import BlockTree, ClusterTree, block_tree, both_ways, cluster_tree
from .measured_error import verified
from .operator import Compressed, Statistics, direct, times, weighted
from .point_kernel import PointKernel

ETA = 1.5  # admissible if the larger diameter is at most this many distances
INSIDE = 0.95  # the proxy surface stays this far within the admissible distance
SINGLE = 1e-4  # tolerances from here on: everything in single precision


@dataclass(frozen=True)
class Level:
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
    levels : tuple of Level
        Leaves and inner nodes of a level apart.
    """

    ptr: np.ndarray
    points: np.ndarray
    levels: tuple[Level, ...]

    @property
    def nbytes(self) -> int:
        arrays = ("starts", "counts", "kept", "picks", "pick_ptr", "T_ptr", "T")
        levels = sum(getattr(level, name).nbytes for level in self.levels for name in arrays)
        return levels + self.ptr.nbytes + self.points.nbytes


class H2Matrix(Compressed):
    """Compressed plain kernel with nested bases; see `h2matrix`."""

    def __init__(
        self,
        kernel: PointKernel,
        basis: csc_matrix | None,
        blocks: BlockTree,
        bases: Bases,
        sources: Bases,
        dtype: type,
        statistics: Statistics,
        test: csc_matrix | None = None,
    ):
        super().__init__(kernel, basis, statistics, test)
        self.blocks, self.bases, self.sources = blocks, bases, sources
        # functions meet a Krylov solver: rounded bases, but products in double precision
        self.dtype_inside = np.dtype(dtype if basis is None else np.float64)
        tree = blocks.tree
        leaves = tree.leaves
        place = np.zeros(tree.n_nodes, dtype=np.int64)
        place[leaves] = np.arange(leaves.size)
        self._leaf_ptr = np.append(tree.start[leaves], tree.order.size)
        self._near = both_ways(place[blocks.near], leaves.size)
        self._far = both_ways(blocks.far, tree.n_nodes)
        self._points_at = kernel.ordered(tree.order)
        self._skeletons = kernel.ordered(tree.order[bases.points])
        self._sources = self._skeletons
        if sources is not bases:
            self._sources = kernel.ordered(tree.order[sources.points])

    @property
    def nbytes(self) -> int:
        """Bytes kept for products."""
        lists = [*self._near[:2], *self._far[:2], self.blocks.tree.order]
        lists += [*self._points_at, *self._skeletons]
        bases = {id(b): b.nbytes for b in (self.bases, self.sources)}
        return sum(bases.values()) + sum(a.nbytes for a in lists)

    def _apply(self, x: np.ndarray) -> np.ndarray:
        if self.basis is None:
            return self._points(x)
        return times(self.test.T, self._points(times(self.basis, x)))

    def _points(self, x: np.ndarray) -> np.ndarray:
        tree, bases = self.blocks.tree, self.bases
        inside = np.ascontiguousarray(x[:, :, tree.order].astype(self.dtype_inside, copy=False))
        y = np.zeros_like(inside)
        charges = np.zeros((x.shape[0], 3, self.sources.points.size), dtype=inside.dtype)
        self._up(inside, charges)
        potentials = np.zeros((x.shape[0], 3, bases.points.size), dtype=inside.dtype)
        self.kernel.sums_between(
            self._skeletons, bases.ptr, self._sources, self.sources.ptr, *self._far[:2],
            charges, potentials,
        )  # fmt: skip
        for s in reversed(bases.levels):
            target = y if s.leaf else potentials
            kernels.down(
                s.starts, s.counts, s.kept, s.picks, s.pick_ptr, s.T_ptr, s.T, target,
                s.skeleton_ptr, potentials,
            )  # fmt: skip
        at, ptr = self._points_at, self._leaf_ptr
        self.kernel.sums_between(at, ptr, at, ptr, *self._near[:2], inside, y)
        out = np.empty(y.shape)
        out[:, :, tree.order] = y
        return out

    def _up(self, inside: np.ndarray, charges: np.ndarray) -> None:
        """Equivalent charges of all nodes, from charges at the points."""
        for s in self.sources.levels:
            source = inside if s.leaf else charges
            kernels.up(
                s.starts, s.counts, s.kept, s.picks, s.pick_ptr, s.T_ptr, s.T, source,
                s.skeleton_ptr, charges,
            )  # fmt: skip


def h2matrix(
    points: np.ndarray,
    tolerance: float,
    *,
    normals: np.ndarray | None = None,
    basis: spmatrix | None = None,
    test: spmatrix | None = None,
    leaf: int | None = None,
    seed: int = 0,
    memory: float | None = None,
) -> Compressed:
    """Compress the single layer with nested bases; parameters as for `hmatrix`, and:

    test : (n, n_dofs) sparse matrix, optional
        Weighted test functions where they differ: the operator is then ``test^T G basis``.

    Raises
    ------
    ValueError
        As for `hmatrix`.
    MemoryError
        A forecast above ``memory``, with both numbers, before anything is allocated.
    """
    kernel = PointKernel(points, normals)
    basis = None if basis is None else weighted(basis, kernel)
    test = None if test is None else weighted(test, kernel)

    def build(target: float) -> H2Matrix:
        return _build(kernel, (basis, test), target, leaf, memory)

    return verified(build, tolerance, seed, lambda note: direct(kernel, basis, note, test))


def forecast(n: int, tolerance: float, limit: float | None) -> float:
    """Bytes of an H2-matrix of n points before it is built; refuse more than ``limit``.

    Measured on spheres and stacked sheets: 1 to 2 kB a point at 1e-3, 2 to 8 kB at 1e-6.
    """
    digits = -np.log10(tolerance)
    total = n * min(150.0 * digits**2.2, 72.0 * n)
    if limit is not None and total > limit:
        raise MemoryError(
            f"the compressed operator would take about {total / 1e9:.2f} GB, {limit / 1e9:.2f} GB "
            'are allowed: raise the tolerance, or use compression = "dense" (direct sums)'
        )
    return total


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


def _build(
    kernel: PointKernel,
    bases_of: tuple[csc_matrix | None, csc_matrix | None],
    tolerance: float,
    leaf: int | None,
    memory: float | None,
) -> H2Matrix:
    began = time.perf_counter()
    basis, test = bases_of
    forecast(kernel.n, tolerance, memory)
    dtype = np.float32 if tolerance >= SINGLE else np.float64
    leaf = leaf or (96 if tolerance >= SINGLE else 160)
    tree = cluster_tree(kernel.scaled.T, leaf=leaf)
    blocks = block_tree(tree, ETA, largest=True)
    bases = sources = nested_bases(kernel, blocks, tolerance, dtype)
    if kernel.normals is not None:
        sources = nested_bases(kernel, blocks, tolerance, dtype, stresslets=True)
    ranks = np.diff(bases.ptr)
    n = kernel.n if basis is None else basis.shape[1]
    operator = H2Matrix(
        kernel,
        basis,
        blocks,
        bases,
        sources,
        dtype,
        Statistics(
            method="h2",
            n=n,
            tolerance=tolerance,
            far_blocks=blocks.far.shape[0],
            near_blocks=blocks.near.shape[0],
            rank_mean=3.0 * float(ranks[ranks > 0].mean()) if ranks.any() else 0.0,
            rank_max=3 * int(ranks.max(initial=0)),
            bytes_far=0,
        ),
        test,
    )
    operator.statistics = replace(
        operator.statistics,
        bytes_far=operator.nbytes,
        build_seconds=time.perf_counter() - began,
    )
    return operator


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
    levels = tuple(_placed(tree, ptr, level) for level in found)
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
) -> Level:
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
    kernels.level_skeletons(
        tree.lower[nodes], tree.upper[nodes], sphere_points(proxy_count(tolerance)), INSIDE / ETA,
        positions, ptr, candidates, tolerance, kept, picks, slot_ptr, slots,
        normals,
    )  # fmt: skip
    for i, node in enumerate(nodes):
        skeletons[node] = lists[i][picks[ptr[i] : ptr[i] + kept[i]]]
    sizes = 9 * kept * (counts - kept)
    T = np.concatenate([slots[a : a + n] for a, n in zip(slot_ptr, sizes, strict=False)])
    T_ptr = np.concatenate([[0], np.cumsum(sizes)])
    none, picks = np.zeros(0, dtype=np.int64), picks.astype(np.int32)
    return Level(none, counts, kept, picks, ptr, T_ptr, T, none, leaf, nodes)


def _placed(tree: ClusterTree, ptr: np.ndarray, level: Level) -> Level:
    """A level with the places of its candidates and skeletons."""
    nodes = level.nodes
    starts = tree.start[nodes] if level.leaf else ptr[tree.children[nodes, 0]]
    return replace(level, starts=starts, skeleton_ptr=ptr[nodes])
