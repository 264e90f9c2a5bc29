"""C1 spline surfaces as a scikit-fem basis: unmodified scikit-fem forms assemble on it.

The parametric mesh is a plain quadrilateral grid; the reference configuration enters through
``dx = |X_s x X_t| ds dt``, so that forms integrate over the reference surface. Derivatives of
``DiscreteField`` are parametric (``grad``, ``hess``); `shells.energy.frame` turns them into
derivatives in an orthonormal tangent frame, all that a parametrization-free energy needs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, identity, kron
from skfem import BilinearForm, MeshQuad
from skfem.assembly.basis import AbstractBasis
from skfem.element import DiscreteField, ElementQuad1

from .jets import Jets
from .spline_surface import SplineSurface
from .splines import bernstein, unit_gauss
from .tensor_surface import TensorSurface
from .vector_functions import VectorFunctions


def _degenerate(surface: TensorSurface, ok: np.ndarray, points: np.ndarray) -> str:
    """Which elements have parallel tangents, and where."""
    bad = np.flatnonzero(~ok.all(axis=1))
    e = int(bad[0])
    i, j = np.divmod(surface.selected[e], surface.t.n_elements)
    q = int(np.flatnonzero(~ok[e])[0])
    where = ", ".join(f"{x:.4g}" for x in points[e, q])
    return (
        f"{bad.size} element(s) of the reference surface are degenerate (parallel tangents or not "
        f"finite): first element ({i}, {j}) near ({where}); check its control points"
    )


class SurfaceBasis(AbstractBasis):
    """Basis functions of a `SplineSurface` at Gauss points of its elements.

    Parameters
    ----------
    surface : TensorSurface
        A `SplineSurface` or a `Pillow`.
    reference : (n_coefficients, 3) array, callable or Jets
        Reference configuration as coefficients, jets at the points, or an exact one:
        ``reference(s, t)`` returns ``X, (X_s, X_t), (X_ss, X_tt, X_st)``, each ``(..., 3)``.
    points : int, optional
        Gauss points per direction; default ``degree + 1``.
    components : {1, 3}
        Scalar or vector functions; vector dof ``3 a + c`` is component c of coefficient a.

    Raises
    ------
    ValueError
        A reference whose tangents are parallel at a quadrature point, or of a wrong shape.
    """

    dimension = 3  # of the space the surface lies in

    def __init__(
        self,
        surface: TensorSurface,
        reference: np.ndarray | Callable | Jets,
        points: int | None = None,
        components: int = 3,
    ):
        self.surface, self.components = surface, components
        n = surface.degree + 1 if points is None else points
        x, w = unit_gauss(n)
        xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
        self.X, self.W = np.stack([xi, eta]), np.outer(w, w).ravel()
        self._evaluate(xi, eta)
        self.source = reference
        self.reference = reference if isinstance(reference, Jets) else self._jets_of(reference)
        area = np.linalg.norm(self.reference.normal, axis=-1)
        if not np.all(ok := area > 1e-14 * area.max()):
            raise ValueError(_degenerate(surface, ok, self.reference.value))
        hs, ht = self.sizes
        self.dx = area * self.W * (hs * ht)[:, None]
        self.mesh = MeshQuad.init_tensor(surface.s.breaks, surface.t.breaks)
        self.mapping = self.mesh._mapping()
        self.elem = ElementQuad1()  # a placeholder: forms never ask it for functions
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

    def mass(self, density: float) -> csr_matrix:
        """Mass matrix of a uniform areal density.

        Parameters
        ----------
        density : float

        Returns
        -------
        (3 n_coefficients, 3 n_coefficients) sparse matrix
        """
        points = round(self.X.shape[1] ** 0.5)
        scalar = SurfaceBasis(self.surface, self.reference, points, components=1)
        form = BilinearForm(lambda u, v, w: density * u * v)
        return kron(form.assemble(scalar), identity(3), format="csr")

    @cached_property
    def sizes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lengths of each element along s and t, ``(n_elements,)``."""
        es, et = np.divmod(self.surface.selected, self.surface.t.n_elements)
        return np.diff(self.surface.s.breaks)[es], np.diff(self.surface.t.breaks)[et]

    def _evaluate(self, xi: np.ndarray, eta: np.ndarray) -> None:
        p, tables = self.surface.degree, self.surface.tables
        hs, ht = self.sizes

        def along(i: int, j: int) -> np.ndarray:
            product = bernstein(p, xi, i)[:, None] * bernstein(p, eta, j)[None]
            values = tables @ product.reshape(-1, xi.size)  # (element, function, point)
            return np.swapaxes(values / (hs**i * ht**j)[:, None, None], 0, 1)

        self.values = along(0, 0)  #: (n_functions, n_elements, n_points)
        self.grads = np.stack([along(1, 0), along(0, 1)])  #: leading axis s, t
        self.hess = np.stack([along(2, 0), along(0, 2), along(1, 1)])  #: ss, tt, st

    def _jets_of(self, reference: np.ndarray | Callable) -> Jets:
        if not callable(reference):
            return self.jets(reference)
        s, t = np.asarray(self.global_coordinates())
        value, grad, hess = reference(s, t)
        return Jets(np.asarray(value), np.stack(grad), np.stack(hess))

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

    def global_coordinates(self) -> DiscreteField:
        """Parameters (s, t) of the quadrature points.

        Returns
        -------
        (2, n_elements, n_points) DiscreteField
        """
        es, et = np.divmod(self.surface.selected, self.surface.t.n_elements)
        hs, ht = self.sizes
        s = self.surface.s.breaks[es][:, None] + hs[:, None] * self.X[0]
        t = self.surface.t.breaks[et][:, None] + ht[:, None] * self.X[1]
        return DiscreteField(np.stack([s, t]))

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
            Callables receive (s, t).
        **_
            Options of scikit-fem that have no meaning here.

        Returns
        -------
        (N,) array
        """
        from skfem.utils import solve

        return solve(*self._projection(interp))

    def boundary(self, direction: str, end: int, layer: int = 0) -> np.ndarray:
        """Dofs of the ``layer``-th ring of coefficients next to a boundary.

        Parameters
        ----------
        direction : {"s", "t"}
        end : {0, 1}
            Start or end of that direction.
        layer : int
            0 is the trace; 1 together with 0 clamps.

        Returns
        -------
        (n,) int array

        Raises
        ------
        ValueError
            A surface that is no `SplineSurface`.
        """
        surface = self.surface
        if not isinstance(surface, SplineSurface):
            raise ValueError("only a SplineSurface has edges of its grid; a Pillow has none")
        pick = surface.ring if direction == "s" else surface.column
        rows = pick(layer if end == 0 else -1 - layer)
        return (self.components * rows[:, None] + np.arange(self.components)).ravel()

    def get_dofs(self, *_: Any, **__: Any) -> np.ndarray:
        """Refuse: splines have no facet dofs, use `boundary`.

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
        raise AttributeError("spline coefficients have no facets: use boundary(direction, end)")
