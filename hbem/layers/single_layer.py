"""Galerkin single layer of Stokes flow on a closed surface [T 3.10a], Re = 1.

``V psi(x) = 1/(8 pi) int (psi / r + r (r . psi) / r^3) dS``, discretised by accurate inner
integrals from outer Gauss points to elements: ``A = B^T W (G W B + C_near)``. The matrix is not
symmetric, and symmetrising it makes the traction ten times worse. ``V n = 0``: tractions are
determined up to a constant pressure, which the constraint ``<tau, n> = 0`` fixes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator

from ..compression.choice import STORED_LIMIT, Compression
from ..near.near_field import NearField, near_field, table_values
from ..near.near_rules import coincidence
from ..solvers.coarse_level import CoarseSpace, coarse_image
from ..surfaces.patches import SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface, sample
from . import _dense_layer_kernels as kernels
from .dense_blocks import ExactBlocks, Use, vector_dofs
from .point_sums import single_layer_sums

CHUNK_BYTES = 48e6  # intermediate columns held at a time


class SingleLayer(LinearOperator):
    """Single layer on density dofs; vector dof ``3 a + i`` is component i of function a.

    Its two forms, stored dense and direct, share this interface.

    Attributes
    ----------
    surface : SampledSurface
        Outer points, weights, normals, basis, mass matrix and constraint.
    near : NearField
        Sparse part ``B^T W C_near``; the rest is ``B^T W G W B`` with plain point kernels.
    """

    def __init__(self, surface: SampledSurface, near: NearField):
        n = 3 * surface.patches.n_dofs
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self.surface, self.near = surface, near

    @property
    def n_near(self) -> int:
        """Number of near (point, element) pairs."""
        return self.near.n_pairs

    def dense(self) -> np.ndarray:
        """The matrix ``(3 n_dofs, 3 n_dofs)``."""
        raise NotImplementedError

    def blocks(self, patches: Sequence[np.ndarray], use: Use) -> list[np.ndarray]:
        """``use(k, block)`` of the exact block ``(3 n, 3 n)`` of each patch's functions."""
        return ExactBlocks(self.surface, self.near).many(patches, use)

    def image(self, coarse: CoarseSpace) -> np.ndarray:
        """Product with all coarse densities, to about 1e-3: ``(3 n_dofs, k)``."""
        return coarse_image(self.surface, self.near, coarse)

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(np.reshape(x, (-1, 1)))[:, 0]


class StoredSingleLayer(SingleLayer):
    """The single layer as a dense matrix: the fastest product of a small system."""

    def __init__(self, surface: SampledSurface, near: NearField):
        super().__init__(surface, near)
        self._matrix = dense_matrix(surface, near)

    def dense(self) -> np.ndarray:
        return self._matrix

    def blocks(self, patches: Sequence[np.ndarray], use: Use) -> list[np.ndarray]:
        parts = map(vector_dofs, patches)
        return [use(k, self._matrix[np.ix_(d, d)]) for k, d in enumerate(parts)]

    def image(self, coarse: CoarseSpace) -> np.ndarray:
        # rows of a transposed product: both factors are then read in their storage order
        return np.asarray(coarse.densities.T.tocsr() @ self._matrix.T).T

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return self._matrix @ x

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        return self._matrix.T @ x

    def _rmatvec(self, x: np.ndarray) -> np.ndarray:
        return self._matrix.T @ x


class DirectSingleLayer(SingleLayer):
    """The single layer as sparse near field and direct point sums; no matrix is stored.

    Needs ``O(n)`` memory and ``O(n^2)`` time a product: good up to some 5000 elements.
    """

    def dense(self) -> np.ndarray:
        return dense_matrix(self.surface, self.near)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        x = np.ascontiguousarray(x, dtype=float).reshape(-1, 3, x.shape[1])
        y = self.near.apply(x) + self.far(x)
        return y.reshape(self.shape[0], -1)

    def far(self, x: np.ndarray) -> np.ndarray:
        """Plain part ``B^T W G W B x`` of densities ``(n_dofs, 3, k)``."""
        outer, source, k = self.surface.outer, self.surface.source, x.shape[2]
        values = self.surface.source_basis @ x.reshape(x.shape[0], -1)
        strengths = (source.weights[:, None] * values).reshape(-1, 3, k)
        strengths = strengths[:, :, 0] if k == 1 else strengths
        sums = single_layer_sums(outer.points, source.points, strengths, coincidence(self.surface))
        return self.surface.project(sums.reshape(sums.shape[0], -1)).reshape(x.shape)


def single_layer(
    patches: SurfacePatches,
    coefficients: np.ndarray,
    orders: QuadratureOrders | None = None,
    *,
    storage: str = "auto",
    compression: Compression | None = None,
) -> SingleLayer:
    """Assemble the single layer on one configuration.

    Parameters
    ----------
    patches : SurfacePatches
        A closed surface with outward normal ``x_s x x_t``.
    coefficients : (n_coefficients, 3) array
    orders : QuadratureOrders, optional
    storage : {"auto", "dense", "direct"}
        Store the matrix, or sum the far field directly at every product; ``auto`` stores
        systems up to `STORED_LIMIT` unknowns.
    compression : Compression, optional
        Compress the plain part, unless ``dense`` stores the matrix.

    Returns
    -------
    SingleLayer
        Operator ``(3 n_dofs, 3 n_dofs)``.

    Raises
    ------
    ValueError
        An unknown storage.
    """
    orders = QuadratureOrders() if orders is None else orders
    if storage not in ("auto", "dense", "direct"):
        raise ValueError(f"storage must be 'auto', 'dense' or 'direct', got {storage!r}")
    surface = sample(patches, coefficients, orders)
    near = near_field(surface, orders)
    stored = storage == "dense" or (storage == "auto" and 3 * patches.n_dofs <= STORED_LIMIT)
    if compression is not None and storage != "dense":
        from .compressed_layer import compressed_single_layer

        return compressed_single_layer(surface, near, compression)
    return (StoredSingleLayer if stored else DirectSingleLayer)(surface, near)


def dense_matrix(surface: SampledSurface, near: NearField) -> np.ndarray:
    """Plain part and near field as one matrix."""
    n = surface.patches.n_dofs
    matrix = np.zeros((n, n, 6))
    tables = _Tables(surface)
    chunk = tables.chunk()
    for first in range(0, surface.patches.n_elements, chunk):
        last = min(first + chunk, surface.patches.n_elements)
        _add_plain(surface, tables, slice(first, last), matrix)
    rows = np.repeat(np.arange(n), np.diff(near.indptr))
    matrix[near.indices, rows] += near.data
    return _interleave(matrix)


def _interleave(matrix: np.ndarray) -> np.ndarray:
    """Six components ``(source, test, 6)`` to the matrix ``(3 n, 3 n)``."""
    n = matrix.shape[0]
    full = np.empty((n, 3, n, 3))
    for i, row in enumerate(((0, 1, 2), (1, 3, 4), (2, 4, 5))):
        for k, c in enumerate(row):
            full[:, i, :, k] = matrix[:, :, c].T
    return full.reshape(3 * n, 3 * n)


@dataclass(frozen=True)
class _Tables:
    """Arrays of a surface in the layout of the kernels."""

    surface: SampledSurface

    def chunk(self) -> int:
        """Target elements per sweep, so that intermediates stay within `CHUNK_BYTES`."""
        per_element = self.surface.outer.per_element * 48 * self.surface.patches.n_dofs
        return max(1, int(CHUNK_BYTES / per_element))

    @cached_property
    def outer_values(self) -> np.ndarray:
        return table_values(self.surface, self.surface.outer)

    @cached_property
    def source_values(self) -> np.ndarray:
        same = self.surface.source is self.surface.outer
        return self.outer_values if same else table_values(self.surface, self.surface.source)

    @cached_property
    def indptr(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.indptr, dtype=np.int64)

    @cached_property
    def dofs(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.dofs, dtype=np.int64)


def _add_plain(
    surface: SampledSurface, tables: _Tables, targets: slice, matrix: np.ndarray
) -> None:
    """Add the plain part ``B^T W G W B`` of some target elements."""
    outer, source = surface.outer, surface.source
    n, nt = surface.patches.n_elements, outer.per_element
    x = outer.points.reshape(n, nt, 3)[targets]
    columns = np.empty((x.shape[0], surface.patches.n_dofs, 6 * nt))
    kernels.source_columns(
        np.ascontiguousarray(np.swapaxes(x, 1, 2)),
        source.points.reshape(n, -1, 3),
        source.weights.reshape(n, -1),
        tables.source_values,
        tables.indptr,
        tables.dofs,
        coincidence(surface),
        columns,
    )
    weights = outer.weights.reshape(n, -1)
    kernels.test_rows(
        columns, weights, tables.outer_values, tables.indptr, tables.dofs, targets.start, matrix
    )
