"""Plane curves on scikit-fem's C1 cubic Hermite line.

Coefficient ``2 k`` is the position of node k, ``2 k + 1`` its derivative by arc length of the
reference; a configuration is ``(2 n_nodes, 2)`` and vector dof ``2 a + c`` is component c of
coefficient a. Curves run counterclockwise: ``rot t = (t_y, -t_x)`` points outward [T 2.20].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, identity, kron
from skfem import Basis, BilinearForm, ElementLineHermite, MeshLine

from .form import Scatter


def rot(vectors: np.ndarray) -> np.ndarray:
    """``(a_1, -a_0)``: a tangent of a counterclockwise curve turned outward [T 2.20]."""
    return np.stack([vectors[..., 1], -vectors[..., 0]], axis=-1)


@dataclass(frozen=True)
class CurveJets:
    """Position, tangent, curvature vector and turned tangent ``(n_elements, n_points, 2)``."""

    value: np.ndarray
    tangent: np.ndarray
    second: np.ndarray

    @property
    def normal(self) -> np.ndarray:
        """Tangent turned outward, as long as the tangent."""
        return rot(self.tangent)


class CurveBasis:
    """Cubic Hermite functions at Gauss points of a line.

    Parameters
    ----------
    nodes : (n_nodes,) array
        Ascending arc lengths of the unstretched curve.
    coefficients : (2 n_nodes, 2) array
        Initial configuration.
    points : int
        Gauss points per element.

    Raises
    ------
    ValueError
        Nodes that do not ascend or coefficients that do not fit.
    """

    dimension = 2  # of the space the curve lies in

    def __init__(self, nodes: np.ndarray, coefficients: np.ndarray, points: int = 5):
        nodes = np.asarray(nodes, dtype=float)
        if nodes.ndim != 1 or nodes.size < 2 or not np.all(np.diff(nodes) > 0.0):
            raise ValueError("nodes must be at least two ascending arc lengths")
        if np.shape(coefficients) != (2 * nodes.size, 2):
            raise ValueError(
                f"expected coefficients {(2 * nodes.size, 2)}, got {np.shape(coefficients)}"
            )
        self.nodes = nodes
        self.scalar = Basis(MeshLine(nodes), ElementLineHermite(), intorder=2 * points - 1)
        fields = [function[0] for function in self.scalar.basis]
        self.values = np.stack(
            [np.broadcast_to(np.asarray(f), self.scalar.dx.shape) for f in fields]
        )
        self.first = np.stack([f.grad[0] for f in fields])
        self.second = np.stack([f.hess[0, 0] for f in fields])
        self.dx = self.scalar.dx
        self.dofs = self.scalar.element_dofs.T
        self.N = 2 * self.scalar.N
        vector = (2 * self.dofs[:, :, None] + np.arange(2)).reshape(self.dofs.shape[0], -1)
        self.scatter = Scatter(np.ascontiguousarray(vector), self.N)
        self.coefficients = np.array(coefficients, dtype=float)
        self.reference = self.jets(self.coefficients)

    def jets(self, coefficients: np.ndarray) -> CurveJets:
        """Position and derivatives of ``(2 n_nodes, 2)`` coefficients at the Gauss points."""
        local = coefficients[self.dofs]
        tables = (self.values, self.first, self.second)
        return CurveJets(*(np.einsum("aeq,eac->eqc", table, local) for table in tables))

    def mass(self, density: float) -> csr_matrix:
        """Mass matrix ``(N, N)`` of a uniform line density."""
        form = BilinearForm(lambda u, v, w: density * u * v)
        return kron(form.assemble(self.scalar), identity(2), format="csr")

    def sample(self, xi: np.ndarray) -> csr_matrix:
        """Positions at local coordinates ``xi`` in [0, 1] of every element, element by element."""
        h = np.diff(self.nodes)[:, None]
        cubic = hermite(np.asarray(xi, dtype=float))
        table = np.tile(cubic, (h.size, 1, 1))
        table[:, :, 1::2] *= h[:, :, None]
        rows = np.repeat(np.arange(h.size * cubic.shape[0]), 4)
        columns = np.repeat(self.dofs, cubic.shape[0], axis=0).ravel()
        return csr_matrix((table.ravel(), (rows, columns)), (rows[-1] + 1, self.N // 2))


def hermite(xi: np.ndarray) -> np.ndarray:
    """The four cubics of one element of length 1: values and slopes at 0, then at 1."""
    return np.stack(
        [
            1.0 - xi**2 * (3.0 - 2.0 * xi),
            xi * (1.0 - xi) ** 2,
            xi**2 * (3.0 - 2.0 * xi),
            xi**2 * (xi - 1.0),
        ],
        axis=-1,
    )
