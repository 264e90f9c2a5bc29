"""The single layer summed directly at every product: nothing is stored but the near field."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from ..near.near_rules import coincident_distance_squared
from ..surfaces.surface_points import PointSet
from .dense_layer import dense_matrix
from .layer import SingleLayer, densities
from .point_sums import single_layer_sums


class DirectSingleLayer(SingleLayer):
    """The single layer as sparse near field and direct point sums; no matrix is stored.

    Needs ``O(n)`` memory and ``O(n^2)`` time a product: good up to some 5000 elements.
    """

    def dense(self) -> np.ndarray:
        return dense_matrix(self.surface, self.near)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        x = densities(x)
        y = self.near.apply(x) + self.far(x)
        return y.reshape(self.shape[0], -1)

    def far(self, x: np.ndarray) -> np.ndarray:
        """Plain part ``B^T W G W B x`` of densities ``(n_dofs, 3, k)``."""
        s = self.surface
        return self._sums((s.outer, s.basis), (s.source, s.source_basis), x)

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        s, x = self.surface, densities(x)
        far = self._sums((s.source, s.source_basis), (s.outer, s.basis), x)
        return (self.near.apply_transposed(x) + far).reshape(self.shape[0], -1)

    def _sums(
        self,
        targets: tuple[PointSet, csr_matrix],
        sources: tuple[PointSet, csr_matrix],
        x: np.ndarray,
    ) -> np.ndarray:
        """Sums between points, with the functions on both sides."""
        (target, test), (source, basis), k = targets, sources, x.shape[2]
        values = basis @ x.reshape(x.shape[0], -1)
        strengths = (source.weights[:, None] * values).reshape(-1, 3, k)
        strengths = strengths[:, :, 0] if k == 1 else strengths
        sums = single_layer_sums(
            target.offsets, source.offsets, strengths, coincident_distance_squared(self.surface)
        )
        weighted = target.weights[:, None] * sums.reshape(sums.shape[0], -1)
        return (test.T @ weighted).reshape(x.shape)
