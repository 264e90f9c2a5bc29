"""Planar membranes with a flat, unstretched reference: what Kirchhoff-Love shells are in 2D.

``W = int k w(q) + eps/2 |D^2 theta|^2`` with ``q = |D theta|^2``, so that
``W' = (2 k w'(q) D theta, D rho) + eps (D^2 theta, D^2 rho)``. The Kirchhoff-Love law has
``w = (q - 1)^2 / 8``: half the square of the strain ``(q - 1)/2`` [T 2.21].
Departs from [T 2.21]: the printed W' is that of k = 2, its strain lacks the factor 1/2.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import final

import numpy as np
from scipy.sparse import csr_matrix

from ..surfaces.curve import CurveBasis
from .interface import ShellEnergy
from .material import Material


class PlanarMembrane(ShellEnergy):
    """A curve with a stretch law and linear bending; `PlanarShell` and `ElasticString` are two.

    Parameters
    ----------
    basis : CurveBasis
    material : Material
        Stiffness k, rigidity eps and line density; the Poisson ratio has no meaning here.
    """

    basis: CurveBasis

    def __init__(self, basis: CurveBasis, material: Material):
        self.basis, self.material = basis, material

    @abstractmethod
    def law(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``w``, ``2 w'`` and ``4 w''`` at the squared stretch q, for unit stiffness."""

    @cached_property
    def _bending(self) -> csr_matrix:
        b = self.basis
        scalar = np.einsum("aeq,beq,eq->eab", b.second, b.second, b.dx)
        elements = np.einsum("eab,ij->eaibj", scalar, np.eye(2)).reshape(-1, 8, 8)
        return self.material.flexural_rigidity * b.scatter.matrix(elements)

    def _stretch(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        d = self.basis.jets(np.reshape(x, (-1, 2))).tangent
        return d, *self.law(np.einsum("eqc,eqc->eq", d, d))

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        _, w, _, _ = self._stretch(x)
        x = np.ravel(x)
        membrane = self.material.stiffness * float((w * self.basis.dx).sum())
        return membrane, 0.5 * float(x @ (self._bending @ x))

    def gradient(self, x: np.ndarray) -> np.ndarray:
        d, _, f, _ = self._stretch(x)
        return self._gradient(x, d, f)

    def _gradient(self, x: np.ndarray, d: np.ndarray, f: np.ndarray) -> np.ndarray:
        b = self.basis
        weight = self.material.stiffness * b.dx * f
        elements = np.einsum("aeq,eqc->eac", b.first, weight[..., None] * d)
        return b.scatter.vector(elements.reshape(-1, 8)) + self._bending @ np.ravel(x)

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        b = self.basis
        d, _, f, df = self._stretch(x)
        k = self.material.stiffness * b.dx
        # departs from [T 2.23b]: the second term is D theta (D theta . D dtheta), not (theta . )
        C = (k * f)[..., None, None] * np.eye(2)
        C = C + (k * df)[..., None, None] * d[..., :, None] * d[..., None, :]
        outer = b.first.transpose(1, 0, 2)[:, :, None] * b.first.transpose(1, 0, 2)[:, None]
        ne, nq = b.dx.shape
        product = outer.reshape(ne, 16, nq) @ C.reshape(ne, nq, 4)
        elements = product.reshape(ne, 4, 4, 2, 2).transpose(0, 1, 3, 2, 4).reshape(ne, 8, 8)
        return self._gradient(x, d, f), b.scatter.matrix(elements) + self._bending

    def stretch(self, x: np.ndarray) -> np.ndarray:
        """``|D theta|`` at the Gauss points."""
        return np.linalg.norm(self.basis.jets(np.reshape(x, (-1, 2))).tangent, axis=-1)


@final
class PlanarShell(PlanarMembrane):
    """Kirchhoff-Love in the plane [T 2.21]."""

    def law(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return (q - 1.0) ** 2 / 8.0, 0.5 * (q - 1.0), np.ones_like(q)
