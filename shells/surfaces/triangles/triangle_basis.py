"""Bezier triangles as a scikit-fem basis: unmodified scikit-fem forms assemble on it.

Triangles have no parameters in common: derivatives are those of each triangle's own xi and eta.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from skfem import Mesh, MeshTri
from skfem.element import DiscreteField, Element, ElementTriP1
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from ..element_basis import ElementBasis
from ..jets import Jets
from ..local_elements import functions
from .triangle_surface import TriangleSurface


class TriangleBasis(ElementBasis):
    """Basis functions of a `TriangleSurface` at the quadrature points of its triangles.

    Parameters
    ----------
    surface : TriangleSurface
    reference : (n_coefficients, 3) array or Jets
        Reference configuration as coefficients, or jets at the points.
    exactness : int, optional
        Polynomial degree that the rule integrates exactly; default twice the surface's (6 points
        at degree 2, 12 at degree 3).
    components : {1, 3}
        Scalar or vector functions; vector dof ``3 a + c`` is component c of coefficient a.

    Raises
    ------
    ValueError
        A reference whose tangents are parallel at a quadrature point, or of a wrong shape.
    """

    surface: TriangleSurface
    edge_dofs = "surface.on_edges(edges)"

    def __init__(
        self,
        surface: TriangleSurface,
        reference: np.ndarray | Jets,
        exactness: int | None = None,
        components: int = 3,
    ):
        self.exactness = 2 * surface.degree if exactness is None else exactness
        super().__init__(surface, reference, components)

    def _rule(self) -> tuple[np.ndarray, np.ndarray]:
        return get_quadrature(RefTri, self.exactness)

    def _functions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        xi, eta = self.X

        def along(i: int, j: int) -> np.ndarray:
            return functions("triangle", self.surface.degree, xi, eta, (i, j)).T

        def everywhere(*tables: np.ndarray) -> np.ndarray:
            # the same for all triangles: views, nothing is copied
            table = np.stack(tables)[:, :, None]
            shape = (*table.shape[:2], self.surface.n_elements, table.shape[3])
            return np.broadcast_to(table, shape)

        second = everywhere(along(2, 0), along(0, 2), along(1, 1))
        return everywhere(along(0, 0))[0], everywhere(along(1, 0), along(0, 1)), second

    def _parameter_weights(self) -> np.ndarray:
        return np.broadcast_to(self.W, (self.surface.n_elements, self.W.size))

    def _placeholders(self) -> tuple[Mesh, Element]:
        count = self.surface.n_elements
        corners = np.tile(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), count)
        vertices = np.ascontiguousarray(np.arange(3 * count).reshape(-1, 3).T)
        return MeshTri(corners, vertices), ElementTriP1()

    def _element_name(self, e: int) -> str:
        return f"triangle {e}"

    def _scalar(self) -> Self:
        return type(self)(self.surface, self.reference, self.exactness, components=1)

    def global_coordinates(self) -> DiscreteField:
        """Position of the quadrature points on the reference.

        Returns
        -------
        (3, n_elements, n_points) DiscreteField
        """
        return DiscreteField(np.moveaxis(self.reference.value, -1, 0))
