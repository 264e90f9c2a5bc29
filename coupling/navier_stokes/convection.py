"""Convection on flagged elements, ``c(u, u, v) = ((u . grad) u, v)`` [T 7.10], and its tangent.

On the reference element ``u . grad phi = (J^-1 u) . grad_ref phi``: shape functions are the same
for all elements, hence vectors and matrices of elements are products of coefficients at points
``(elements, points)`` with fixed tables. The skew-symmetric form is
``d(u, v, w) = c(u, v, w) / 2 - c(u, w, v) / 2`` [T 7.13].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skfem import FacetBasis

from .spaces import FlowSpace


@dataclass(frozen=True)
class Convection:
    """Convection of a flow space.

    Attributes
    ----------
    space : FlowSpace
    skew : bool
        Take the form of [T 7.13].
    outlet : skfem.FacetBasis, optional
        Where the skew form needs its outflow term.
    wind : (n,) array, optional
        Field that convects in place of the solution: the problem is linear then.
    """

    space: FlowSpace
    skew: bool = False
    outlet: FacetBasis | None = None
    wind: np.ndarray | None = None

    @cached_property
    def _tables(self) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions ``(k, q)`` and their reference gradients ``(2, k, q)``."""
        basis = self.space.velocity
        k = basis.Nbfun
        both = [basis.elem.lbasis(basis.X, i) for i in range(k)]
        return np.array([b[0] for b in both]), np.stack([b[1] for b in both], axis=1)

    @cached_property
    def _products(self) -> tuple[np.ndarray, np.ndarray]:
        """``phi_i phi_j`` as ``(q, k k)`` and ``phi_i d_a phi_j`` as ``(2, q, k k)``."""
        phi, dphi = self._tables
        q = phi.shape[1]
        mass = np.einsum("iq,jq->qij", phi, phi).reshape(q, -1)
        return mass, np.einsum("iq,ajq->aqij", phi, dphi).reshape(2, q, -1)

    @cached_property
    def _inverse(self) -> np.ndarray:
        """Inverse Jacobian of the element maps, ``(2, 2, n_elements, q)``."""
        basis = self.space.velocity
        return basis.mapping.invDF(basis.X)

    def elements(self, x: np.ndarray, z: np.ndarray, flagged: np.ndarray) -> np.ndarray:
        """Element integrals of ``((u . grad) u) . z`` (or their skew form), 0 where not flagged.

        Parameters
        ----------
        x, z : (n,) array
        flagged : (n_elements,) bool array

        Returns
        -------
        (n_elements,) array
        """
        rows = np.flatnonzero(flagged)
        dofs = self.space.velocity.element_dofs[:, rows]
        parts = self._vectors(x, rows)
        values = sum(
            np.einsum("ie,ei->e", c[dofs], v)
            for c, v in zip(self.space.split(z)[:2], parts, strict=True)
        )
        result = np.zeros(self.space.n_elements)
        result[rows] = values
        return result

    def vector(self, x: np.ndarray, flagged: np.ndarray) -> np.ndarray:
        """``c(u, u, v)`` over the flagged elements for all test functions, ``(n,)``."""
        rows = np.flatnonzero(flagged)
        n = self.space.n_velocity
        dofs = self.space.velocity.element_dofs[:, rows].T.ravel()
        result = np.zeros(self.space.n)
        for i, part in enumerate(self._vectors(x, rows)):
            result[i * n : (i + 1) * n] = np.bincount(dofs, part.ravel(), minlength=n)
        return result

    def matrices(self, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Tangents of elements with respect to both components, ``(m, 2 k, 2 k)``.

        Parameters
        ----------
        x : (n,) array
        rows : (m,) int array
            Elements.
        """
        mass, first = self._products
        k, m = self.space.velocity.Nbfun, rows.size
        u, gradient, w, inverse = self._at_points(x, rows)
        a = u if self.wind is None else self._at_points(self.wind, rows)[0]
        carried = self._reference(w * a, inverse)
        convective = sum(carried[b] @ first[b] for b in range(2)).reshape(m, k, k)
        if self.skew:
            convective = 0.5 * (convective - convective.transpose(0, 2, 1))
        result = np.zeros((m, 2, k, 2, k))
        half = 0.5 if self.skew else 1.0
        for i in range(2):
            result[:, i, :, i, :] = convective
            for j in range(2 if self.wind is None else 0):
                block = (half * w * gradient[i, j]) @ mass
                result[:, i, :, j, :] += block.reshape(m, k, k)
                if self.skew:
                    weight = [0.5 * w * u[i] * inverse[b, j] for b in range(2)]
                    block = sum(weight[b] @ first[b] for b in range(2)).reshape(m, k, k)
                    result[:, i, :, j, :] -= block.transpose(0, 2, 1)
        if self.skew and self.outlet is not None:
            self._add_outflow_tangent(self.outlet, x, rows, result)
        return result.reshape(m, 2 * k, 2 * k)

    def _vectors(self, x: np.ndarray, rows: np.ndarray) -> list[np.ndarray]:
        """Both components of the element vectors, ``(m, k)`` each."""
        phi, dphi = self._tables
        u, gradient, w, inverse = self._at_points(x, rows)
        a = u if self.wind is None else self._at_points(self.wind, rows)[0]
        half = 0.5 if self.skew else 1.0
        result = [half * w * (a[0] * gradient[i, 0] + a[1] * gradient[i, 1]) for i in range(2)]
        result = [c @ phi.T for c in result]
        if self.skew:
            carried = self._reference(w * a, inverse)
            for i in range(2):
                result[i] -= sum((0.5 * carried[b] * u[i]) @ dphi[b].T for b in range(2))
            if self.outlet is not None:
                self._add_outflow(self.outlet, x, rows, result)
        return result

    def _at_points(self, x: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, ...]:
        """Velocity ``(2, m, q)``, gradient ``(2, 2, m, q)``, weights, inverse Jacobian."""
        phi, dphi = self._tables
        inverse = self._inverse[:, :, rows]
        w = self.space.velocity.dx[rows]
        dofs = self.space.velocity.element_dofs[:, rows].T
        local = [c[dofs] for c in self.space.split(x)[:2]]
        u = np.stack([c @ phi for c in local])
        reference = np.stack([[c @ dphi[b] for b in range(2)] for c in local])
        gradient = np.einsum("ibeq,bjeq->ijeq", reference, inverse)
        return u, gradient, w, inverse

    @staticmethod
    def _reference(a: np.ndarray, inverse: np.ndarray) -> np.ndarray:
        """A vector field at points in reference coordinates."""
        return np.einsum("bjeq,jeq->beq", inverse, a)

    def _outflow(
        self, basis: FacetBasis, x: np.ndarray, rows: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """On outlet facets of ``rows``: element's place, shapes, weights, velocity, normal."""
        place = np.full(self.space.n_elements, -1)
        place[rows] = np.arange(rows.size)
        chosen = np.flatnonzero(place[basis.tind] >= 0)
        phi = np.array([np.asarray(f[0])[chosen] for f in basis.basis])
        dofs = basis.element_dofs[:, chosen]
        u = np.stack([np.einsum("ie,ieq->eq", c[dofs], phi) for c in self.space.split(x)[:2]])
        at = place[basis.tind[chosen]]
        return at, phi, basis.dx[chosen], u, basis.normals[:, chosen]

    def _add_outflow(
        self, outlet: FacetBasis, x: np.ndarray, rows: np.ndarray, result: list[np.ndarray]
    ) -> None:
        # departs from [T 7.13], written for enclosed flow: (u . n) u . v / 2 on the outlet keeps
        # its condition sigma n = 0, so that skew and plain form have the same solutions
        at, phi, w, u, n = self._outflow(outlet, x, rows)
        a = u if self.wind is None else self._outflow(outlet, self.wind, rows)[3]
        flow = 0.5 * w * np.einsum("jeq,jeq->eq", a, n)
        for i in range(2):
            np.add.at(result[i], at, np.einsum("eq,keq->ek", flow * u[i], phi))

    def _add_outflow_tangent(
        self, outlet: FacetBasis, x: np.ndarray, rows: np.ndarray, result: np.ndarray
    ) -> None:
        at, phi, w, u, n = self._outflow(outlet, x, rows)
        a = u if self.wind is None else self._outflow(outlet, self.wind, rows)[3]
        flow = 0.5 * w * np.einsum("jeq,jeq->eq", a, n)
        for i in range(2):
            blocks = np.einsum("eq,keq,leq->ekl", flow, phi, phi)
            np.add.at(result[:, i, :, i, :], at, blocks)
            for j in range(2 if self.wind is None else 0):
                weight = 0.5 * w * u[i] * n[j]
                blocks = np.einsum("eq,keq,leq->ekl", weight, phi, phi)
                np.add.at(result[:, i, :, j, :], at, blocks)
