"""Bezier elements of any shape as a scikit-fem basis: what squares and triangles have in common.

The reference configuration enters through ``dx = |X_xi x X_eta| dxi deta``, so that forms integrate
over the reference surface. Derivatives of ``DiscreteField`` are parametric (``grad``, ``hess``);
`shells.energy.frame` turns them into derivatives in an orthonormal tangent frame, all that a
parametrization-free energy needs.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
from scipy.sparse import csr_matrix, identity, kron
from skfem import BilinearForm, Mesh
from skfem.assembly.basis import AbstractBasis
from skfem.element import DiscreteField, Element

from .jets import Jets
from .surface import Surface
from .vector_functions import VectorFunctions


class ElementBasis(AbstractBasis):
    """Basis functions of a `Surface` at the quadrature points of its elements.

    Attributes
    ----------
    values, grads, hess : (n_functions, n_elements, n_points) arrays
        Functions, with a leading axis first (2) and second derivatives (3: ss, tt, st).
    reference : Jets
        Reference configuration at the points; `source` is what it was given by.
    parameter_weights : (n_elements, n_points) array
        Weights of the points in the parameters; ``dx`` are those on the reference surface.
    """

    dimension = 3  # of the space the surface lies in
    values: np.ndarray
    grads: np.ndarray
    hess: np.ndarray

    def __init__(
        self, surface: Surface, reference: np.ndarray | Callable | Jets, components: int
    ) -> None:
        self.surface, self.components = surface, components
        self.X, self.W = self._rule()
        self.values, self.grads, self.hess = self._functions()
        self.source = reference
        self.reference = reference if isinstance(reference, Jets) else self._jets_of(reference)
        area = np.linalg.norm(self.reference.normal, axis=-1)
        if not np.all(ok := area > 1e-14 * area.max()):
            raise ValueError(self._degenerate(ok))
        self.parameter_weights = self._parameter_weights()
        self.dx = area * self.parameter_weights
        self.mesh, self.elem = self._placeholders()
        self.mapping = self.mesh._mapping()
        self.nelems = surface.n_elements
        self.tind = None
        dofs = surface.element_dofs.T
        if components > 1:
            dofs = (components * dofs[:, None] + np.arange(components)[:, None]).reshape(
                -1, self.nelems
            )
        self.dofs = SimpleNamespace(
            element_dofs=dofs.astype(np.int32), N=components * surface.n_coefficients
        )
        self.Nbfun = dofs.shape[0]
        self.basis = VectorFunctions(self.values, self.grads, self.hess, components)

    @abstractmethod
    def _rule(self) -> tuple[np.ndarray, np.ndarray]:
        """Local points ``(2, n)`` and weights ``(n,)``."""

    @abstractmethod
    def _functions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`values`, `grads`, `hess`."""

    @abstractmethod
    def _parameter_weights(self) -> np.ndarray: ...

    @abstractmethod
    def _placeholders(self) -> tuple[Mesh, Element]:
        """A mesh of as many elements, and an element that forms never ask for functions."""

    @abstractmethod
    def _element_name(self, e: int) -> str: ...

    @abstractmethod
    def _scalar(self) -> Self: ...

    @cached_property
    def scalar(self) -> Self:
        """The same basis with one component."""
        return self if self.components == 1 else self._scalar()

    def _degenerate(self, ok: np.ndarray) -> str:
        """Which elements have parallel tangents, and where."""
        bad = np.flatnonzero(~ok.all(axis=1))
        e = int(bad[0])
        q = int(np.flatnonzero(~ok[e])[0])
        where = ", ".join(f"{x:.4g}" for x in self.reference.value[e, q])
        return (
            f"{bad.size} element(s) of the reference surface are degenerate (parallel tangents or "
            f"not finite): first {self._element_name(e)} near ({where}); check its control points"
        )

    def _jets_of(self, reference: np.ndarray | Callable) -> Jets:
        if not callable(reference):
            return self.jets(reference)
        value, grad, hess = reference(*np.asarray(self.global_coordinates()))
        return Jets(np.asarray(value), np.stack(grad), np.stack(hess))

    def mass(self, density: float) -> csr_matrix:
        """Mass matrix of a uniform areal density.

        Parameters
        ----------
        density : float

        Returns
        -------
        (3 n_coefficients, 3 n_coefficients) sparse matrix
        """
        form = BilinearForm(lambda u, v, w: density * u * v)
        return kron(form.assemble(self.scalar), identity(3), format="csr")

    def jets(self, coefficients: np.ndarray) -> Jets:
        """A field and its derivatives at the quadrature points.

        Parameters
        ----------
        coefficients : (n_coefficients, 3) array

        Returns
        -------
        Jets

        Raises
        ------
        ValueError
            Coefficients of another shape.
        """
        coefficients = np.asarray(coefficients)
        if coefficients.shape != (self.surface.n_coefficients, 3):
            raise ValueError(
                f"expected coefficients ({self.surface.n_coefficients}, 3), "
                f"got {coefficients.shape}"
            )
        local = coefficients[self.surface.element_dofs]
        return Jets(
            np.einsum("aeq,eac->eqc", self.values, local, optimize=True),
            np.einsum("daeq,eac->deqc", self.grads, local, optimize=True),
            np.einsum("daeq,eac->deqc", self.hess, local, optimize=True),
        )

    # --- the scikit-fem interface -----------------------------------------------------------

    def default_parameters(self) -> dict[str, DiscreteField]:
        """Position ``x`` and unit normal ``n`` of the reference, element size ``h``.

        Returns
        -------
        dict of DiscreteField
        """
        normal = self.reference.normal
        unit = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        size = np.sqrt(self.dx.sum(axis=1, keepdims=True)) * np.ones_like(self.dx)
        return {
            "x": DiscreteField(np.moveaxis(self.reference.value, -1, 0)),
            "n": DiscreteField(np.moveaxis(unit, -1, 0)),
            "h": DiscreteField(size),
        }

    @abstractmethod
    def global_coordinates(self) -> DiscreteField:
        """Coordinates of the quadrature points that callables receive."""

    def interpolate(self, w: np.ndarray) -> DiscreteField:
        """A field at the quadrature points, with both derivatives.

        Parameters
        ----------
        w : (N,) array
            Its dof vector.

        Returns
        -------
        DiscreteField

        Raises
        ------
        ValueError
            A vector of another length.
        """
        if w.shape != (self.N,):
            raise ValueError(f"expected a dof vector of length {self.N}, got shape {w.shape}")
        local = w.reshape(-1, self.components)[self.surface.element_dofs]
        value = np.einsum("aeq,eac->ceq", self.values, local, optimize=True)
        grad = np.einsum("daeq,eac->cdeq", self.grads, local, optimize=True)
        h = np.einsum("daeq,eac->cdeq", self.hess, local, optimize=True)
        hess = np.stack([h[:, 0], h[:, 2], h[:, 2], h[:, 1]], axis=1)
        hess = hess.reshape(self.components, 2, 2, *h.shape[2:])
        if self.components == 1:
            value, grad, hess = value[0], grad[0], hess[0]
        return DiscreteField(value=value, grad=grad, hess=hess)

    def project(self, interp: Callable | np.ndarray | float, **_: Any) -> np.ndarray:
        """L2 projection onto the basis.

        Parameters
        ----------
        interp : callable, array or float
            Callables receive the `global_coordinates`.
        **_
            Options of scikit-fem that have no meaning here.

        Returns
        -------
        (N,) array
        """
        from skfem.utils import solve

        return solve(*self._projection(interp))

    def get_dofs(self, *_: Any, **__: Any) -> np.ndarray:
        """Refuse: coefficients are no facet dofs.

        Parameters
        ----------
        *_, **__
            Whatever scikit-fem passes.

        Returns
        -------
        (n,) int array
            Never.

        Raises
        ------
        AttributeError
            Always.
        """
        raise AttributeError(f"coefficients have no facets: use {self.edge_dofs}")

    edge_dofs = "those of the surface's edges"  #: where the dofs of an edge are found
