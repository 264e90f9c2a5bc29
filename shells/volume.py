"""Enclosed volume ``Q = 1/3 int theta . (theta_s x theta_t) ds dt`` [T 2.27, 2.30].

Both variations are exact for the discrete Q whatever the quadrature. The full form is meant for
surfaces that are closed, or whose boundary does not move: on an open moving boundary its gradient
would contain a spurious edge load.
"""

from __future__ import annotations

import numpy as np

from . import _shell_kernels as kernels
from .form import ElementForm, Scatter
from .surface_basis import SurfaceBasis


class EnclosedVolume:
    """Volume under a surface, with gradient and Hessian.

    Parameters
    ----------
    basis : SurfaceBasis
        Vector basis of the part of the surface that moves.
    offset : float
        Volume of the part that does not (the inflow patch).
    """

    def __init__(self, basis: SurfaceBasis, offset: float = 0.0):
        self.basis, self.offset = basis, offset
        stacked = np.stack([basis.values, basis.grads[0], basis.grads[1]])
        self._values = np.ascontiguousarray(np.moveaxis(stacked, (0, 1), (3, 2)))
        hs, ht = basis._sizes
        self._dw = np.ascontiguousarray(basis.W * (hs * ht)[:, None])
        self._dofs = basis.surface.element_dofs
        self._scatter = Scatter(np.ascontiguousarray(basis.element_dofs.T), basis.N)
        self.gradient_form = ElementForm(lambda x: self._elements(x, 1)[1], basis, 1, self._scatter)
        self.hessian_form = ElementForm(lambda x: self._elements(x, 2)[2], basis, 2, self._scatter)

    def _elements(self, x: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        ne, nd = self._dofs.shape[0], 3 * self._dofs.shape[1]
        Q = np.empty(ne)
        R = np.empty((ne, nd) if order > 0 else (1, 1))
        K = np.empty((ne, nd, nd) if order > 1 else (1, 1, 1))
        c = np.ascontiguousarray(np.asarray(x, dtype=float).reshape(-1, 3))
        kernels.volume_terms(self._values, self._dw, self._dofs, c, order, Q, R, K)
        return Q, R, K

    def value(self, x: np.ndarray) -> float:
        """Enclosed volume at coefficients ``(n_coefficients, 3)``."""
        return float(self._elements(x, 0)[0].sum()) + self.offset

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Q' as a dof vector ``(3 n_coefficients,)``."""
        return self._scatter.vector(self._elements(x, 1)[1])

    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, object]:
        """Q, Q' and Q'' (CSR) from one pass."""
        Q, R, K = self._elements(x, 2)
        return float(Q.sum()) + self.offset, self._scatter.vector(R), self._scatter.matrix(K)
