"""Area between a plane curve and the chord from its end to its start [T 2.29]: ``1/2 x^T A x``.

The area is quadratic in the coefficients; five Gauss points integrate it exactly.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ..surfaces.curve import CurveBasis
from .interface import Enclosure


class EnclosedArea(Enclosure):
    """The area of a curve on one basis: what `EnclosedVolume` is to surfaces.

    Parameters
    ----------
    basis : CurveBasis
    """

    def __init__(self, basis: CurveBasis):
        self.basis = basis

    @cached_property
    def matrix(self) -> csr_matrix:
        """A, symmetric ``(N, N)``; the closing chord included."""
        b = self.basis
        moment = np.einsum("aeq,beq,eq->eab", b.values, b.first, b.dx)
        turn = np.array([[0.0, 1.0], [-1.0, 0.0]])  # x . rot Dy = x_0 Dy_1 - x_1 Dy_0
        elements = np.einsum("eab,ij->eaibj", moment, turn)
        elements = elements.reshape(moment.shape[0], 8, 8)
        half = b.scatter.matrix(0.5 * (elements + elements.swapaxes(1, 2))).tolil()
        end, start = b.N - 4, 0  # chord from the last node's position back to the first's
        for (i, j), sign in {(0, 1): 0.5, (1, 0): -0.5}.items():
            half[end + i, start + j] += sign
            half[start + j, end + i] += sign
        return half.tocsr()

    def value(self, x: np.ndarray) -> float:
        x = np.ravel(x)
        return 0.5 * float(x @ (self.matrix @ x))

    def gradient(self, x: np.ndarray) -> np.ndarray:
        return self.matrix @ np.ravel(x)

    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, csr_matrix]:
        gradient = self.gradient(x)
        return 0.5 * float(np.ravel(x) @ gradient), gradient, self.matrix

    def check(self, extraction: csr_matrix) -> None:
        return  # nothing to refuse: the chord follows the ends
