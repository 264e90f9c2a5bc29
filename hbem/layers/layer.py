"""The single layer as every caller sees it, whether stored, summed directly or compressed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from scipy.sparse.linalg import LinearOperator

from ..near.near_field import NearField
from ..surfaces.surface_points import SampledSurface
from .dense_blocks import Consume, ExactBlocks


class SingleLayer(LinearOperator, ABC):
    """Single layer on density dofs; vector dof ``3 a + i`` is component i of function a.

    A scipy ``LinearOperator``: ``layer @ x`` takes ``(3 n_dofs,)`` or ``(3 n_dofs, k)``.

    Parameters
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

    @abstractmethod
    def dense(self) -> np.ndarray:
        """Assemble the matrix, unless it is stored.

        Returns
        -------
        (3 n_dofs, 3 n_dofs) array
        """

    def blocks(self, subdomains: Sequence[np.ndarray], consume: Consume) -> list[np.ndarray]:
        """Hand the exact block of each subdomain's functions to a function, on all threads.

        Parameters
        ----------
        subdomains : sequence of (n,) int array
            Density functions of each subdomain.
        consume : callable
            ``consume(k, block)`` of subdomain k and its block ``(3 n, 3 n)``, which is freed when
            it returns.

        Returns
        -------
        list of array
            What ``consume`` returned, by subdomain.
        """
        return ExactBlocks(self.surface, self.near).map_blocks(subdomains, consume)

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(np.reshape(x, (-1, 1)))[:, 0]

    def _rmatvec(self, x: np.ndarray) -> np.ndarray:
        return self._rmatmat(np.reshape(x, (-1, 1)))[:, 0]


def densities(x: np.ndarray) -> np.ndarray:
    """Columns ``(3 n, k)`` as densities ``(n, 3, k)``.

    Raises
    ------
    ValueError
        Complex columns.
    """
    if np.iscomplexobj(x):
        raise ValueError("complex densities: multiply by real and imaginary part apart")
    return np.ascontiguousarray(x, dtype=float).reshape(-1, 3, x.shape[1])
