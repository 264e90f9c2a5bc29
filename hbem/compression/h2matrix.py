"""H2-matrix of a plain Stokes kernel: nested bases from skeletons, coupling on the fly.

The charges of a cluster are replaced by equivalent ones on a few of its points, level by level
upwards; clusters far from each other exchange the exact kernel between skeletons; potentials go
down by the transposed interpolations (`nested_bases`). Near boxes are summed on the fly between
points, and stored between functions where memory allows (`stored_near`).
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from scipy.sparse import csc_matrix, spmatrix

from .._threads_kernels import over
from ..near.near_field import NearField
from . import _nested_basis_kernels as kernels
from .cluster_tree import BlockTree, block_tree, grouped_tree, list_partners, refuse_above
from .near_part.stored_near import stored_near
from .nested_bases import ETA, Bases, nested_bases
from .operator import (
    Compressed,
    Statistics,
    build_to_tolerance,
    direct,
)
from .point_kernel import PointKernel, checked_basis

SINGLE = 1e-4  # tolerances from here on: everything in single precision


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
        near: NearField | None = None,
    ):
        super().__init__(kernel, basis, statistics, test)
        self.near = near
        self.blocks, self.bases, self.sources = blocks, bases, sources
        # functions meet a Krylov solver: rounded bases, but products in double precision
        self.dtype_inside = np.dtype(dtype if basis is None else np.float64)
        tree = blocks.tree
        leaves = tree.leaves
        place = np.zeros(tree.n_nodes, dtype=np.int64)
        place[leaves] = np.arange(leaves.size)
        self._leaf_ptr = np.append(tree.start[leaves], tree.order.size)
        self._near = list_partners(place[blocks.near], leaves.size)
        self._far = list_partners(blocks.far, tree.n_nodes)
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
        y = self._between_functions(x, self._points)
        if self.near is not None:
            y += self.near.apply(x.T).T
        return y

    def _turned(self) -> H2Matrix:
        turned = super()._turned()
        assert isinstance(turned, H2Matrix)
        turned.near = None if self.near is None else self.near.transposed()
        return turned

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
            over(
                s.starts.size, kernels.down, s.starts, s.counts, s.kept, s.picks, s.pick_ptr,
                s.T_ptr, s.T, target, s.skeleton_ptr, potentials,
            )  # fmt: skip
        if self.near is None:
            at, ptr = self._points_at, self._leaf_ptr
            self.kernel.sums_between(at, ptr, at, ptr, *self._near[:2], inside, y)
        out = np.empty(y.shape)
        out[:, :, tree.order] = y
        return out

    def _up(self, inside: np.ndarray, charges: np.ndarray) -> None:
        """Equivalent charges of all nodes, from charges at the points."""
        for s in self.sources.levels:
            source = inside if s.leaf else charges
            over(
                s.starts.size, kernels.up, s.starts, s.counts, s.kept, s.picks, s.pick_ptr,
                s.T_ptr, s.T, source, s.skeleton_ptr, charges,
            )  # fmt: skip


def h2matrix(
    points: np.ndarray,
    tolerance: float,
    *,
    normals: np.ndarray | None = None,
    basis: spmatrix | None = None,
    test: spmatrix | None = None,
    leaf: int | None = None,
    group: int = 1,
    seed: int = 0,
    memory: float | None = None,
) -> Compressed:
    """Compress a layer's point kernel by nested bases: the double layer's if ``normals`` are given.

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
    test : (n, n_dofs) sparse matrix, optional
        Weighted test functions where they differ: the operator is then ``test^T G basis``.
    leaf : int, optional
        Largest number of points in a leaf.
    group : int
        Points of an element, which follow each other and share a leaf.
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
    test = None if test is None else checked_basis(test, kernel)

    def build(target: float) -> H2Matrix:
        return _build(kernel, (basis, test), target, leaf, group, memory)

    def exact(note: str) -> Compressed:
        return direct(kernel, basis, note, test)

    return build_to_tolerance(build, tolerance, seed, exact)


def forecast(n: int, tolerance: float, limit: float | None) -> float:
    """Bytes of an H2-matrix of n points before it is built; refuse more than ``limit``.

    Measured on spheres and stacked sheets: 1 to 2 kB a point at 1e-3, 2 to 8 kB at 1e-6.
    """
    digits = -np.log10(tolerance)
    total = n * min(150.0 * digits**2.2, 72.0 * n)
    return refuse_above(limit, total, '"dense"')


def _build(
    kernel: PointKernel,
    bases_of: tuple[csc_matrix | None, csc_matrix | None],
    tolerance: float,
    leaf: int | None,
    group: int,
    memory: float | None,
) -> H2Matrix:
    began = time.perf_counter()
    basis, test = bases_of
    forecast(kernel.n, tolerance, memory)
    dtype = np.float32 if tolerance >= SINGLE else np.float64
    fine = 72 if basis is None else 96  # stored boxes may be larger than those that are summed
    leaf = leaf or (fine if tolerance >= SINGLE else 160)
    tree = grouped_tree(kernel.scaled.T, group, leaf)
    blocks = block_tree(tree, ETA, largest=True)
    bases = sources = nested_bases(kernel, blocks, tolerance, dtype)
    if kernel.normals is not None:
        sources = nested_bases(kernel, blocks, tolerance, dtype, stresslets=True)
    near = None
    if basis is not None:
        place = np.zeros(tree.n_nodes, dtype=np.int64)
        place[tree.leaves] = np.arange(tree.leaves.size)
        test = basis if test is None else test
        room = (
            None
            if memory is None
            else memory - sum({id(b): b.nbytes for b in (bases, sources)}.values())
        )
        near = stored_near(kernel, tree, place[blocks.near], basis, test, dtype, room)
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
            bytes_near=0 if near is None else near.nbytes,
        ),
        test,
        near,
    )
    operator.statistics = replace(
        operator.statistics,
        bytes_far=operator.nbytes,
        build_seconds=time.perf_counter() - began,
    )
    return operator
