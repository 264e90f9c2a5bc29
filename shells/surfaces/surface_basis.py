"""C1 spline surfaces as a scikit-fem basis: unmodified scikit-fem forms assemble on it.

The parametric mesh is a plain quadrilateral grid; what it shares with triangles is in
`element_basis`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Self

import numpy as np
from skfem import Mesh, MeshQuad
from skfem.element import DiscreteField, Element, ElementQuad1

from .element_basis import ElementBasis
from .jets import Jets
from .spline_surface import SplineSurface
from .splines import bernstein, unit_gauss
from .tensor_surface import TensorSurface


class SurfaceBasis(ElementBasis):
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

    surface: TensorSurface
    edge_dofs = "boundary(direction, end)"

    def __init__(
        self,
        surface: TensorSurface,
        reference: np.ndarray | Callable | Jets,
        points: int | None = None,
        components: int = 3,
    ):
        self._points = surface.degree + 1 if points is None else points
        super().__init__(surface, reference, components)

    @cached_property
    def sizes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lengths of each element along s and t, ``(n_elements,)``."""
        es, et = np.divmod(self.surface.selected, self.surface.t.n_elements)
        return np.diff(self.surface.s.breaks)[es], np.diff(self.surface.t.breaks)[et]

    def _rule(self) -> tuple[np.ndarray, np.ndarray]:
        x, w = unit_gauss(self._points)
        xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
        return np.stack([xi, eta]), np.outer(w, w).ravel()

    def _functions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        p, tables, (xi, eta) = self.surface.degree, self.surface.tables, self.X
        hs, ht = self.sizes

        def along(i: int, j: int) -> np.ndarray:
            product = bernstein(p, xi, i)[:, None] * bernstein(p, eta, j)[None]
            values = tables @ product.reshape(-1, xi.size)  # (element, function, point)
            return np.swapaxes(values / (hs**i * ht**j)[:, None, None], 0, 1)

        second = np.stack([along(2, 0), along(0, 2), along(1, 1)])
        return along(0, 0), np.stack([along(1, 0), along(0, 1)]), second

    def _parameter_weights(self) -> np.ndarray:
        hs, ht = self.sizes
        return self.W * (hs * ht)[:, None]

    def _placeholders(self) -> tuple[Mesh, Element]:
        mesh = MeshQuad.init_tensor(self.surface.s.breaks, self.surface.t.breaks)
        return mesh, ElementQuad1()

    def _element_name(self, e: int) -> str:
        i, j = np.divmod(self.surface.selected[e], self.surface.t.n_elements)
        return f"element ({i}, {j})"

    def _scalar(self) -> Self:
        return type(self)(self.surface, self.reference, self._points, components=1)

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
