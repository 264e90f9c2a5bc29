"""The single layer as a dense matrix ``B^T W (G W B + C_near)`` [T 3.10a]: small systems."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..near.near_field import NearField
from ..surfaces.surface_points import SampledSurface
from .dense_blocks import Consume, ExactBlocks, vector_dofs
from .layer import SingleLayer


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
    return ExactBlocks(surface, near).all()
