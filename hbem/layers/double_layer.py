"""Galerkin double layer of Stokes flow on closed surfaces [T 3.10b], with subtraction.

``K u(x) = 3/(4 pi) int r (r . u) (r . n) / r^5 dS``, ``r = x - y``, taken as
``int k(x, y) (u(y) - u(x)) dS - u(x) / 2 = int k u dS - (int k dS + 1/2) u(x)``: constants give
``-u / 2`` at every outer point, whatever the quadrature. What is subtracted is the defect of the
Gauss identity: small on a closed surface, large on an open one or with inward normals.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator

from .._threads_kernels import over
from ..near.closest_point import NearPairs, outer_pairs
from ..near.near_field import FULL, NearField, assemble
from ..near.near_rules import Layer, coincident_distance_squared, near_moments
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface
from . import _double_layer_kernels as kernels
from .layer import densities
from .point_sums import pad_to_blocks


class DoubleLayer(LinearOperator):
    """``B^T W K B`` on densities; vector dof ``3 a + i`` is component i of function a.

    Products sum the far field directly; `dense` assembles the matrix once, for many of them.

    Parameters
    ----------
    surface : SampledSurface
    near : NearField
    defect : (n_points, 6) array
        ``int k dS + 1/2`` at the outer points, components 00 01 02 11 12 22.
    """

    def __init__(self, surface: SampledSurface, near: NearField, defect: np.ndarray):
        n = 3 * surface.patches.n_dofs
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self.surface, self.near, self.defect = surface, near, defect

    @property
    def gauss_error(self) -> float:
        """Largest entry of the defect; a health indicator of surface and quadrature."""
        return float(np.abs(self.defect).max())

    def dense(self) -> np.ndarray:
        """Assemble the matrix, once; products then use it.

        Returns
        -------
        (3 n_dofs, 3 n_dofs) array
        """
        return self._matrix

    @cached_property
    def _matrix(self) -> np.ndarray:
        n = self.surface.patches.n_dofs
        blocks = _plain_matrix(self.surface) + _local(self.surface, self.defect)
        rows = np.repeat(np.arange(n), np.diff(self.near.indptr))
        blocks[:, rows, self.near.indices] += self.near.data.T
        full = blocks[FULL].reshape(3, 3, n, n).transpose(2, 0, 3, 1)
        return full.reshape(3 * n, 3 * n)

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(np.reshape(x, (-1, 1)))[:, 0]

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        if "_matrix" not in self.__dict__:
            raise NotImplementedError(
                "the transposed double layer needs the matrix: call dense() once before"
            )
        return self._matrix.T @ x

    def _rmatvec(self, x: np.ndarray) -> np.ndarray:
        return self._rmatmat(np.reshape(x, (-1, 1)))[:, 0]

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        if "_matrix" in self.__dict__:
            return self._matrix @ x
        surface = self.surface
        x = densities(x)
        far = plain_sums(surface, _at(surface.source_basis, x))
        own = np.einsum("pik,pkc->pic", _matrices(self.defect), _at(surface.basis, x))
        rest = (far - own).reshape(own.shape[0], -1)
        y = self.near.apply(x) + surface.project(rest).reshape(x.shape)
        return y.reshape(self.shape[0], -1)


def double_layer(surface: SampledSurface, orders: QuadratureOrders) -> DoubleLayer:
    """Assemble the double layer on a sampled surface: its near field and the Gauss defect.

    Parameters
    ----------
    surface : SampledSurface
        Closed, normals outward.
    orders : QuadratureOrders
        Those of the surface.

    Returns
    -------
    DoubleLayer
        Operator ``(3 n_dofs, 3 n_dofs)``.
    """
    n = surface.outer.offsets.shape[0]
    pairs = outer_pairs(surface, orders, slice(0, n))
    defect = plain_kernel(surface)
    defect[:, [0, 3, 5]] += 0.5
    start = 0

    def moments(part: NearPairs) -> np.ndarray:
        nonlocal start
        found = near_moments(surface, part, orders, Layer.DOUBLE, minus_plain=True)
        point_of = np.repeat(np.arange(part.indptr.size - 1), np.diff(part.indptr))
        np.add.at(defect[start:], point_of, found.sum(axis=1))
        start += part.indptr.size - 1
        return found

    return DoubleLayer(surface, assemble(surface, pairs, moments), defect)


def plain_sums(surface: SampledSurface, values: np.ndarray) -> np.ndarray:
    """Plain double-layer sums at the outer points, coincident points skipped.

    Parameters
    ----------
    surface : SampledSurface
    values : (n_source_points, 3, k) array
        Densities at the source points.

    Returns
    -------
    (n_points, 3, k) array
    """
    source, outer = surface.source, surface.outer
    x, strengths = pad_to_blocks(outer.offsets), np.ascontiguousarray(np.swapaxes(values, 1, 2))
    out = np.empty((x.shape[0], strengths.shape[1], 3, kernels.BLOCK))
    normals = source.weights[:, None] * source.normals
    within = coincident_distance_squared(surface)
    over(x.shape[0], kernels.double_sums, x, source.offsets, normals, strengths, within, out)
    shape = (x.shape[0] * kernels.BLOCK, 3, strengths.shape[1])
    return out.transpose(0, 3, 2, 1).reshape(shape)[: outer.offsets.shape[0]]


def plain_kernel(surface: SampledSurface) -> np.ndarray:
    """Plain sums of the kernel itself at the outer points, ``(n_points, 6)``."""
    source, x = surface.source, pad_to_blocks(surface.outer.offsets)
    out = np.empty((x.shape[0], 6, kernels.BLOCK))
    normals = source.weights[:, None] * source.normals
    within = coincident_distance_squared(surface)
    over(x.shape[0], kernels.kernel_sums, x, source.offsets, normals, within, out)
    return out.transpose(0, 2, 1).reshape(-1, 6)[: surface.outer.offsets.shape[0]].copy()


def _at(basis: csr_matrix, x: np.ndarray) -> np.ndarray:
    """Values at points of densities ``(n_dofs, 3, k)``."""
    return (basis @ x.reshape(x.shape[0], -1)).reshape(-1, *x.shape[1:])


def _matrices(six: np.ndarray) -> np.ndarray:
    return six[:, FULL].reshape(-1, 3, 3)


def _local(surface: SampledSurface, defect: np.ndarray) -> np.ndarray:
    """``-B^T W defect B`` by component, ``(6, n, n)``."""
    basis, weights = surface.basis, surface.outer.weights
    parts = [
        (basis.T @ basis.multiply((-weights * defect[:, c])[:, None])).toarray() for c in range(6)
    ]
    return np.stack(parts)


def _plain_matrix(surface: SampledSurface) -> np.ndarray:
    """``B^T W K_plain W B`` by component, ``(6, n, n)``."""
    source, n = surface.source, surface.patches.n_dofs
    blocks = pad_to_blocks(surface.outer.offsets)
    test = surface.basis.multiply(surface.outer.weights[:, None]).tocsr()
    normals = source.weights[:, None] * source.normals
    kernel = np.empty((6, source.offsets.shape[0], kernels.BLOCK))
    total = np.zeros((6, n, n))
    transposed = surface.source_basis.T.tocsr()
    within = coincident_distance_squared(surface)
    for b, x in enumerate(blocks):
        over(len(normals), kernels.double_matrix, x, source.offsets, normals, within, kernel)
        rows = test[b * kernels.BLOCK : (b + 1) * kernels.BLOCK]
        touched = np.unique(rows.indices)
        few = rows[:, touched].T.toarray()
        for c in range(6):
            columns = transposed @ kernel[c][:, : rows.shape[0]]
            total[c, touched] += few @ columns.T
    return total
