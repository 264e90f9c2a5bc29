"""H-matrix of a plain Stokes kernel between points, or projected to density functions.

``A = B^T W G W B`` over all pairs of points (coincident ones skipped): admissible blocks by
verified cross approximation, the others summed on the fly (points) or stored (functions). The
error against exact rows is measured at the end; above the tolerance the matrix is built again at
a quarter of it, and still above it everything is summed exactly. Nothing fails silently.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, spmatrix

from .._threads_kernels import over
from . import _near_block_kernels as block_kernels
from .cluster_tree import BlockTree, ClusterTree, block_tree, refuse_above
from .cross_approximation import ClusterPoints, approximate_blocks, cluster_points, item_tree
from .far_field import FarField, far_field, leaf_pairs, leaf_ranges
from .operator import (
    Compressed,
    Statistics,
    build_to_tolerance,
    direct,
)
from .point_kernel import PointKernel, checked_basis

SINGLE = 1e-5  # tolerances from here on: far field in single precision
SINGLE_NEAR = 1e-4  # and from here on sums of the near field as well
# Ranks above this many m n / (m + n) cost more than the full block: bytes read against pairs summed
# (measured: 12 GB/s, 1.0 Gpair/s in double and 2.3 in single precision), or bytes against bytes.
FULL_RANK = {"single": 0.45, "mixed": 0.95, "double": 0.48, "stored": 3.5}


class HMatrix(Compressed):
    """Compressed plain kernel; see `hmatrix`."""

    def __init__(
        self,
        kernel: PointKernel,
        basis: csc_matrix | None,
        blocks: BlockTree,
        far: FarField,
        near: NearSums | NearBlocks,
        statistics: Statistics,
    ):
        super().__init__(kernel, basis, statistics)
        self.blocks, self.far, self.near = blocks, far, near

    def _apply(self, x: np.ndarray) -> np.ndarray:
        order = self.blocks.tree.order
        inside = np.ascontiguousarray(x[:, :, order])
        y = np.zeros_like(inside)
        # functions meet a Krylov solver: rounded panels, but products in double precision
        exact = self.basis is not None or self.far.dtype == y.dtype
        low: np.ndarray = inside if exact else inside.astype(self.far.dtype)
        part = y if exact else np.zeros_like(low)
        self.far.add_product(low, part)
        if part is not y:
            y += part
        self.near.add_product(inside, y)
        out = np.empty_like(y)
        out[:, :, order] = y
        return out


@dataclass(frozen=True)
class NearSums:
    """Near blocks summed on the fly from the points, in the precision ``dtype``."""

    kernel: PointKernel
    at: tuple[np.ndarray, np.ndarray]
    leaf_ptr: np.ndarray
    ptr: np.ndarray
    partners: np.ndarray
    dtype: type

    @property
    def nbytes(self) -> int:
        return self.partners.nbytes + sum(a.nbytes for a in self.at)

    def add_product(self, x: np.ndarray, y: np.ndarray) -> None:
        at, ptr = self.at, self.leaf_ptr
        low: np.ndarray = x.astype(self.dtype, copy=False)
        self.kernel.sums_between(at, ptr, at, ptr, self.ptr, self.partners, low, y)


@dataclass(frozen=True)
class NearBlocks:
    """Near blocks stored by pairs of functions, both ways, six components each."""

    leaf_ptr: np.ndarray
    ptr: np.ndarray
    partners: np.ndarray
    data_ptr: np.ndarray
    data: np.ndarray

    @property
    def nbytes(self) -> int:
        return self.data.nbytes

    def add_product(self, x: np.ndarray, y: np.ndarray) -> None:
        over(
            self.leaf_ptr.size - 1, block_kernels.apply_blocks, self.leaf_ptr, self.ptr,
            self.partners, self.data_ptr, self.data, x, y,
        )  # fmt: skip


def hmatrix(
    points: np.ndarray,
    tolerance: float,
    *,
    normals: np.ndarray | None = None,
    basis: spmatrix | None = None,
    leaf: int | None = None,
    eta: float = 2.0,
    seed: int = 0,
    memory: float | None = None,
) -> Compressed:
    """Compress a layer's point kernel by ACA: the double layer's if ``normals`` are given.

    Parameters
    ----------
    points : (n, 3) array
    tolerance : float
        Relative error in the 2-norm for random and for constant densities; it is measured, and
        kept, or the matrix is built again more finely.
    normals : (n, 3) array, optional
        Normals at the sources: the kernel is ``3/(4 pi) r r (r . n) / r^5`` with ``r = x - y``.
    basis : (n, n_dofs) sparse matrix, optional
        Weighted functions ``W B``; the operator is then ``(W B)^T G (W B)``.
    leaf : int, optional
        Largest number of points or functions in a leaf.
    eta : float
        Admissible if the smaller diameter is at most eta times the distance.
    seed : int
        Of the sampled rows.
    memory : float, optional
        Bytes that the operator may take.

    Returns
    -------
    Compressed
        Operator ``(3 n, 3 n)`` or ``(3 n_dofs, 3 n_dofs)`` with its ``statistics``.

    Raises
    ------
    ValueError
        Wrong shapes, points that are not finite, or a tolerance outside (0, 1).
    MemoryError
        A forecast above ``memory``, with both numbers, before anything is allocated.
    """
    kernel = PointKernel(points, normals)
    basis = None if basis is None else checked_basis(basis, kernel)
    leaf = leaf or (100 if basis is None else 32)

    def build(target: float) -> HMatrix:
        return _build(kernel, basis, target, leaf, eta, seed, memory)

    return build_to_tolerance(build, tolerance, seed, lambda note: direct(kernel, basis, note))


def _build(
    kernel: PointKernel,
    basis: csc_matrix | None,
    tolerance: float,
    leaf: int,
    eta: float,
    seed: int,
    memory: float | None,
) -> HMatrix:
    began = time.perf_counter()
    symmetric = kernel.normals is None
    tree = item_tree(kernel.scaled.T, basis, leaf)
    blocks = block_tree(tree, eta)
    clusters = cluster_points(tree, basis)
    dtype = np.float32 if tolerance >= SINGLE else np.float64
    forecast(blocks, tolerance, dtype, stored=basis is not None, symmetric=symmetric, limit=memory)
    far_blocks = blocks.far if symmetric else np.concatenate([blocks.far, blocks.far[:, ::-1]])
    share = full_rank(tolerance, stored=basis is not None)
    parts = approximate_blocks(
        far_blocks, clusters, kernel, tolerance=tolerance, full_rank=share, dtype=dtype, seed=seed
    )
    far = far_field(tree, list(parts), symmetric=symmetric, dtype=dtype)
    full = far_blocks[far.ranks < 0]
    near = _near(kernel, basis, blocks, clusters, full, tolerance, symmetric)
    statistics = Statistics(
        method="aca",
        n=tree.order.size,
        tolerance=tolerance,
        far_blocks=int((far.ranks >= 0).sum()),
        full_blocks=full.shape[0],
        near_blocks=blocks.near.shape[0],
        rank_mean=float(far.ranks[far.ranks > 0].mean()) if (far.ranks > 0).any() else 0.0,
        rank_max=int(far.ranks.max(initial=0)),
        bytes_far=far.nbytes,
        bytes_near=near.nbytes,
        build_seconds=time.perf_counter() - began,
    )
    return HMatrix(kernel, basis, blocks, far, near, statistics)


def full_rank(tolerance: float, *, stored: bool) -> float:
    """Largest rank that pays, in units of ``m n / (m + n)`` items."""
    if stored:
        return FULL_RANK["stored"]
    if tolerance < SINGLE:
        return FULL_RANK["double"]
    return FULL_RANK["single" if tolerance >= SINGLE_NEAR else "mixed"]


def forecast(
    blocks: BlockTree,
    tolerance: float,
    dtype: type,
    *,
    stored: bool,
    symmetric: bool,
    limit: float | None,
) -> float:
    """Bytes of an H-matrix before it is built; refuse more than ``limit``.

    Ranks grow like ``4 + 2.2 log10(1 / tol)^2`` (measured between 1e-2 and 1e-8), never above
    the rank from which blocks are left full.
    """
    sizes = blocks.tree.sizes.astype(float)
    m, n = sizes[blocks.far].T if blocks.far.size else np.zeros((2, 0))
    share = full_rank(tolerance, stored=stored) * m * n / (m + n + 1.0)
    rank = np.minimum(4.0 + 2.2 * np.log10(1.0 / tolerance) ** 2, share)
    far = float((rank * 3.0 * (m + n)).sum()) * np.dtype(dtype).itemsize
    m, n = sizes[blocks.near].T
    near = float((m * n).sum()) * 12.0 * np.dtype(dtype).itemsize if stored else 0.0
    total = (far if symmetric else 2.0 * far) + near
    return refuse_above(limit, total, '"h2" or "dense"')


def forecast_points(points: np.ndarray, tolerance: float) -> float:
    """Bytes of the H-matrix of a point cloud, before it is built."""
    tree = item_tree(PointKernel(points).scaled.T, None, 100)
    dtype = np.float32 if tolerance >= SINGLE else np.float64
    blocks = block_tree(tree, 2.0)
    return forecast(blocks, tolerance, dtype, stored=False, symmetric=True, limit=None)


def _near(
    kernel: PointKernel,
    basis: csc_matrix | None,
    blocks: BlockTree,
    clusters: ClusterPoints,
    full: np.ndarray,
    tolerance: float,
    symmetric: bool,
) -> NearSums | NearBlocks:
    tree = blocks.tree
    first, last, leaf_ptr = leaf_ranges(tree)
    pairs = np.concatenate([first[blocks.near], leaf_pairs(full, first, last)])
    mirrored = pairs[:, ::-1] if symmetric else first[blocks.near][:, ::-1]
    pairs = np.unique(np.concatenate([pairs, mirrored]), axis=0)
    ptr = np.searchsorted(pairs[:, 0], np.arange(leaf_ptr.size))
    if basis is None:
        dtype = np.float32 if tolerance >= SINGLE_NEAR else np.float64
        at, partners = kernel.ordered(tree.order), np.ascontiguousarray(pairs[:, 1])
        return NearSums(kernel, at, leaf_ptr, ptr, partners, dtype)
    return near_blocks(kernel, clusters, tree, pairs, ptr, tolerance)


def near_blocks(
    kernel: PointKernel,
    clusters: ClusterPoints,
    tree: ClusterTree,
    pairs: np.ndarray,
    ptr: np.ndarray,
    tolerance: float,
) -> NearBlocks:
    """Compute and store the blocks of sorted pairs of leaves; a symmetric kernel gives two."""
    leaves = tree.leaves
    leaf_ptr = np.append(tree.start[leaves], tree.order.size)
    sizes, (t, s) = np.diff(leaf_ptr), np.ascontiguousarray(pairs.T)
    data_ptr = np.concatenate([[0], np.cumsum(6 * sizes[t] * sizes[s])])
    data = np.empty(data_ptr[-1], dtype=np.float32 if tolerance >= SINGLE else np.float64)
    mirror, wanted = np.full(t.size, -1), np.arange(t.size)
    if kernel.normals is None:
        wanted = np.flatnonzero(t <= s)
        above = np.flatnonzero(t < s)
        key = t * leaves.size + s
        mirror[above] = np.searchsorted(key, s[above] * leaves.size + t[above])
    over(
        wanted.size, block_kernels.near_blocks, wanted, leaves[t], leaves[s], mirror,
        clusters.item_ptr, clusters.items, clusters.point_ptr, clusters.points, kernel.scaled,
        kernel.scaled_normals, kernel.within, *clusters.columns, data_ptr, data,
    )  # fmt: skip
    return NearBlocks(leaf_ptr, ptr, s, data_ptr, data)
