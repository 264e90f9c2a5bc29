"""scikit-fem forms around element kernels, with the scatter to global arrays cached.

`ElementForm` is a `skfem` form whose element arrays come from one fused kernel instead of a loop
over pairs of basis functions; ``assemble`` and ``elemental`` keep their scikit-fem meaning. The
sparsity pattern is found once: afterwards an assembly is a single ``bincount``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem.assembly.form.form import Form

from .element_basis import ElementBasis


class Scatter:
    """Element matrices to CSR with a pattern computed once from ``element_dofs``."""

    def __init__(self, element_dofs: np.ndarray, n: int):
        rows = np.repeat(element_dofs, element_dofs.shape[1], axis=1).ravel().astype(np.int64)
        cols = np.tile(element_dofs, (1, element_dofs.shape[1])).ravel()
        keys, self._slot = np.unique(rows * n + cols, return_inverse=True)
        self.n, self.indices = n, (keys % n).astype(np.int32)
        self.indptr = np.searchsorted(keys, np.arange(n + 1, dtype=np.int64) * n)
        self._dofs = element_dofs

    def matrix(self, elements: np.ndarray) -> csr_matrix:
        """Sum ``(n_elements, m, m)`` into an ``(n, n)`` matrix."""
        data = np.bincount(self._slot, elements.ravel(), minlength=self.indices.size)
        return csr_matrix((data, self.indices, self.indptr), shape=(self.n, self.n))

    def vector(self, elements: np.ndarray) -> np.ndarray:
        """Sum ``(n_elements, m)`` into an ``(n,)`` vector."""
        return np.bincount(self._dofs.ravel(), elements.ravel(), minlength=self.n)


class ElementForm(Form):
    """A linear (rank 1) or bilinear (rank 2) form given by its element arrays.

    Parameters
    ----------
    kernel : callable
        ``kernel(x)`` with dof vector x returns ``(n_elements, m)`` or ``(n_elements, m, m)``.
    basis : ElementBasis
        The basis whose dofs the element arrays refer to.
    """

    def __init__(self, kernel: Callable, basis: ElementBasis, rank: int, scatter: Scatter):
        super().__init__(None)
        self._kernel, self._basis, self._rank, self._scatter = kernel, basis, rank, scatter

    def _arrays(self, basis: ElementBasis, x: np.ndarray) -> np.ndarray:
        if basis is not self._basis:
            raise ValueError("this form belongs to another basis")
        return self._kernel(x)

    def _assemble(self, ubasis: ElementBasis, vbasis: Any = None, *, x: np.ndarray) -> tuple:
        dofs = ubasis.element_dofs
        m, ne = dofs.shape
        arrays = np.moveaxis(self._arrays(ubasis, x), 0, -1)
        if self._rank == 1:
            return dofs.reshape(1, -1), arrays.ravel(), (ubasis.N,), (m,)
        # scikit-fem orders local data (trial, test, element)
        rows = np.broadcast_to(dofs[None], (m, m, ne)).ravel()
        cols = np.broadcast_to(dofs[:, None], (m, m, ne)).ravel()
        data = np.swapaxes(arrays, 0, 1).ravel()
        return np.stack([rows, cols]), data, (ubasis.N, ubasis.N), (m, m)

    def assemble(self, basis: ElementBasis, *, x: np.ndarray) -> Any:
        """Global vector or CSR matrix at the dof vector ``x``."""
        arrays = self._arrays(basis, x)
        return self._scatter.vector(arrays) if self._rank == 1 else self._scatter.matrix(arrays)
