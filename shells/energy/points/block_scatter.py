"""Element matrices over different sets of coefficients summed into one CSR matrix.

The pattern is found once, by coefficients instead of vector dofs: every pair is a block 3 x 3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix

from .._shell_kernels import PAIRS
from . import _block_kernels as kernels


class BlockScatter:
    """Sums symmetric matrices of several groups of elements.

    Parameters
    ----------
    groups : sequence of (n_elements, m) int arrays
        Coefficients of the elements of each group.
    n : int
        Number of coefficients.
    """

    def __init__(self, groups: Sequence[np.ndarray], n: int):
        self.n = n
        keys = [(dofs[:, :, None] * np.int64(n) + dofs[:, None, :]).ravel() for dofs in groups]
        used, slot = np.unique(np.concatenate(keys), return_inverse=True)
        row, column = np.divmod(used, n)
        ends = np.searchsorted(row, np.arange(n + 1))
        lengths = 3 * np.diff(ends)
        starts = 9 * ends[row] + 3 * (np.arange(used.size) - ends[row])
        cut = np.cumsum([key.size for key in keys])[:-1]
        self._start = [
            starts[part].reshape(*dofs.shape, dofs.shape[1]).astype(np.int32)
            for part, dofs in zip(np.split(slot, cut), groups, strict=True)
        ]
        self._length = [lengths[dofs].astype(np.int32) for dofs in groups]
        vector = (3 * dofs[..., None] + np.arange(3) for dofs in groups)
        self._vector_dofs = [dofs.ravel() for dofs in vector]
        full = np.zeros((used.size, 3, 3), dtype=np.int8)
        pattern = bsr_matrix((full, column, ends), shape=(3 * n, 3 * n)).tocsr()
        self.indptr, self.indices = pattern.indptr, pattern.indices

    def zeros(self) -> np.ndarray:
        """Data of an empty matrix."""
        return np.zeros(self.indices.size)

    def add(self, data: np.ndarray, group: int, K: np.ndarray, part: slice = slice(None)) -> None:
        """Add matrices ``(n, m, 6, m)``, as `JetSums.tangent` returns them."""
        kernels.add_blocks(K, self._start[group][part], self._length[group][part], data)

    def matrix(self, data: np.ndarray) -> csr_matrix:
        """The matrix with these data."""
        return csr_matrix((data, self.indices, self.indptr), shape=(3 * self.n, 3 * self.n))

    def vector(self, group: int, R: np.ndarray) -> np.ndarray:
        """Sum ``(n_elements, m, 3)`` into a ``(3 n,)`` vector."""
        return np.bincount(self._vector_dofs[group], R.ravel(), minlength=3 * self.n)


def whole(K: np.ndarray) -> np.ndarray:
    """Symmetric matrices ``(n, 3 m, 3 m)`` of their pairs ``(n, m, 6, m)``."""
    n, m = K.shape[:2]
    full = np.empty((n, m, 3, m, 3))
    for s, (i, j) in enumerate(PAIRS):
        block = K[:, :, s]
        if i == j:  # read once, as `add_blocks` does
            block = np.tril(block) + np.tril(block, -1).swapaxes(1, 2)
        full[:, :, i, :, j], full[:, :, j, :, i] = block, block.swapaxes(1, 2)
    return full.reshape(n, 3 * m, 3 * m)
