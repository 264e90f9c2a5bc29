"""The single layer summed directly at every product: nothing is stored but the near field."""

from __future__ import annotations

import numpy as np

from ..near.near_rules import coincident_distance_squared
from .dense_layer import dense_matrix
from .layer import SingleLayer
from .point_sums import single_layer_sums


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
        sums = single_layer_sums(
            outer.offsets, source.offsets, strengths, coincident_distance_squared(self.surface)
        )
        return self.surface.project(sums.reshape(sums.shape[0], -1)).reshape(x.shape)
