"""What every single layer can do, however it is stored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse.linalg import LinearOperator

from ..near.near_field import NearField
from ..solvers.coarse_level import CoarseSpace, coarse_image
from ..surfaces.surface_points import SampledSurface
from .dense_blocks import ExactBlocks, Use


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
