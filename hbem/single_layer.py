"""Galerkin single layer of Stokes flow on a closed surface [T 3.10a], Re = 1.

``V psi(x) = 1/(8 pi) int (psi / r + r (r . psi) / r^3) dS``, discretised by accurate inner
integrals from outer Gauss points to elements: ``A = B^T W (G W B + C_near)``. The matrix is not
symmetric, and symmetrising it makes the traction ten times worse. ``V n = 0``: tractions are
determined up to a constant pressure, which the constraint ``<tau, n> = 0`` fixes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator

from . import _far_kernels as kernels
from .closest_point import outer_pairs
from .near import coincidence, near_correction
from .patches import SurfacePatches, tensor_bernstein
from .quadrature import QuadratureOrders
from .sampling import PointSet, SampledSurface, sample

CHUNK_BYTES = 48e6  # intermediate columns held at a time
PAIR_BYTES = 40 * 6 * 8  # about forty near pairs a point, six components


class SingleLayer(LinearOperator):
    """Dense single layer on density dofs; vector dof ``3 a + i`` is component i of function a.

    Attributes
    ----------
    surface : SampledSurface
        Outer points, weights, normals, basis, mass matrix and constraint.
    n_near : int
        Number of near (point, element) pairs.
    """

    def __init__(self, matrix: np.ndarray, surface: SampledSurface, n_near: int):
        super().__init__(dtype=matrix.dtype, shape=matrix.shape)
        self._matrix, self.surface, self.n_near = matrix, surface, n_near

    def dense(self) -> np.ndarray:
        """The matrix ``(3 n_dofs, 3 n_dofs)``; not a copy."""
        return self._matrix

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return self._matrix @ x

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matrix @ x

    def _adjoint(self) -> LinearOperator:
        return SingleLayer(self._matrix.T, self.surface, self.n_near)


def single_layer(
    patches: SurfacePatches, coefficients: np.ndarray, orders: QuadratureOrders | None = None
) -> SingleLayer:
    """Assemble the single layer on one configuration.

    Parameters
    ----------
    patches : SurfacePatches
        A closed surface with outward normal ``x_s x x_t``.
    coefficients : (n_coefficients, 3) array
    orders : QuadratureOrders, optional

    Returns
    -------
    SingleLayer
        Operator ``(3 n_dofs, 3 n_dofs)``.
    """
    orders = QuadratureOrders() if orders is None else orders
    surface = sample(patches, coefficients, orders)
    tables = _Tables(surface)
    n = patches.n_dofs
    matrix = np.zeros((n, n, 6))
    n_near, chunk = 0, tables.chunk()
    for first in range(0, patches.n_elements, chunk):
        last = min(first + chunk, patches.n_elements)
        n_near += _add_rows(surface, tables, orders, slice(first, last), matrix)
    return SingleLayer(_interleave(matrix), surface, n_near)


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
        patches, nt = self.surface.patches, self.surface.outer.per_element
        functions = (patches.density_degree + 1) ** 2
        per_element = nt * (48 * patches.n_dofs + PAIR_BYTES * functions)
        return max(1, int(CHUNK_BYTES / per_element))

    def values(self, points: PointSet) -> np.ndarray:
        """Table rows at local points, ``(n_rows, per_element)``."""
        patches = self.surface.patches
        return patches.extraction @ tensor_bernstein(patches.density_degree, points.s, points.t).T

    @cached_property
    def outer_values(self) -> np.ndarray:
        return self.values(self.surface.outer)

    @cached_property
    def source_values(self) -> np.ndarray:
        same = self.surface.source is self.surface.outer
        return self.outer_values if same else self.values(self.surface.source)

    @cached_property
    def indptr(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.indptr, dtype=np.int64)

    @cached_property
    def dofs(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.dofs, dtype=np.int64)

    @cached_property
    def extraction(self) -> np.ndarray:
        return np.ascontiguousarray(self.surface.patches.extraction, dtype=float)


def _add_rows(
    surface: SampledSurface,
    tables: _Tables,
    orders: QuadratureOrders,
    targets: slice,
    matrix: np.ndarray,
) -> int:
    """Add the test rows of some target elements; returns their number of near pairs."""
    outer, source = surface.outer, surface.source
    n, nt = surface.patches.n_elements, outer.per_element
    points = slice(targets.start * nt, targets.stop * nt)
    pairs = outer_pairs(surface, orders, points)
    moments = near_correction(surface, pairs, orders)
    x = outer.points[points].reshape(-1, nt, 3)
    columns = np.empty((x.shape[0], surface.patches.n_dofs, 6 * nt))
    kernels.source_columns(
        np.ascontiguousarray(np.swapaxes(x, 1, 2)),
        source.points.reshape(n, -1, 3),
        source.weights.reshape(n, -1),
        tables.source_values,
        tables.indptr,
        tables.dofs,
        tables.extraction,
        pairs.indptr,
        pairs.elements,
        moments,
        coincidence(surface),
        columns,
    )
    weights = outer.weights.reshape(n, -1)
    kernels.test_rows(
        columns, weights, tables.outer_values, tables.indptr, tables.dofs, targets.start, matrix
    )
    return pairs.n_pairs
