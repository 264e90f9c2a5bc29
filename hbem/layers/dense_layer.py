"""The single layer as a dense matrix ``B^T W (G W B + C_near)`` [T 3.10a]: small systems.

The plain part is summed in chunks of target elements, then the near field is added.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .._threads_kernels import over
from ..near.near_field import NearField
from ..near.near_rules import coincident_distance_squared
from ..surfaces.surface_points import SampledSurface
from . import _dense_layer_kernels as kernels
from .dense_blocks import Consume, DensityTables, vector_dofs
from .layer import SingleLayer

CHUNK_BYTES = 48e6  # intermediate columns held at a time


class StoredSingleLayer(SingleLayer):
    """The single layer as a dense matrix: the fastest product of a small system."""

    def __init__(self, surface: SampledSurface, near: NearField):
        super().__init__(surface, near)
        self._matrix = dense_matrix(surface, near)

    def dense(self) -> np.ndarray:
        return self._matrix

    def blocks(self, subdomains: Sequence[np.ndarray], consume: Consume) -> list[np.ndarray]:
        parts = map(vector_dofs, subdomains)
        return [consume(k, self._matrix[np.ix_(d, d)]) for k, d in enumerate(parts)]

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return self._matrix @ x

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        return self._matrix.T @ x


def dense_matrix(surface: SampledSurface, near: NearField) -> np.ndarray:
    """Plain part and near field as one matrix."""
    n = surface.patches.n_dofs
    matrix = np.zeros((n, n, 6))
    tables = DensityTables(surface)
    # target elements of a sweep, so that intermediates stay within bounds
    chunk = max(1, int(CHUNK_BYTES / (surface.outer.per_element * 48 * n)))
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


def _add_plain(
    surface: SampledSurface, tables: DensityTables, targets: slice, matrix: np.ndarray
) -> None:
    """Add the plain part ``B^T W G W B`` of some target elements."""
    outer, source = surface.outer, surface.source
    n, nt = surface.patches.n_elements, outer.per_element
    x = outer.offsets.reshape(n, nt, 3)[targets]
    columns = np.empty((x.shape[0], surface.patches.n_dofs, 6 * nt))
    over(
        x.shape[0],
        kernels.source_columns,
        np.ascontiguousarray(np.swapaxes(x, 1, 2)),
        source.offsets.reshape(n, -1, 3),
        source.weights.reshape(n, -1),
        tables.source_values,
        tables.indptr,
        tables.dofs,
        coincident_distance_squared(surface),
        columns,
    )
    weights = outer.weights.reshape(n, -1)
    over(
        matrix.shape[0],
        kernels.test_rows,
        columns,
        weights,
        tables.outer_values,
        tables.indptr,
        tables.dofs,
        targets.start,
        matrix,
    )
