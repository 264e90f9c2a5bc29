"""An edge of a surface with its Gauss points: line loads and end moments.

A line load is dead; an end moment turns with the edge: its virtual work is
``m int nu . rho_s / |t_s| dl``, s pointing across the edge, so that force and tangent follow the
configuration.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import bsr_matrix, csr_matrix, kron

from ..surfaces.spline_surface import SplineSurface
from ..surfaces.splines import unit_gauss
from ..surfaces.tensor_surface import TensorSurface


@dataclass(frozen=True)
class Edge:
    """Gauss points along an edge.

    Attributes
    ----------
    value, across, along : (n_points, n_coefficients) sparse matrix
        Coefficients to values and to derivatives across and along the edge.
    weights : (n_points,) array
        Reference length of each point.
    """

    value: csr_matrix
    across: csr_matrix
    along: csr_matrix
    weights: np.ndarray

    @cached_property
    def _vector_tables(self) -> tuple[csr_matrix, csr_matrix]:
        """Derivatives across and along of vector fields."""
        eye = np.eye(3)
        return kron(self.across, eye, format="csr"), kron(self.along, eye, format="csr")

    def line_load(self, force: ArrayLike) -> np.ndarray:
        """Load ``(n_coefficients, 3)`` of a force per reference length, ``(3,)`` or a point's."""
        density = np.broadcast_to(force, (self.weights.size, 3))
        return self.value.T @ (self.weights[:, None] * density)

    def moment(self, coefficients: np.ndarray, size: float) -> tuple[np.ndarray, csr_matrix]:
        """End moment per reference length on a configuration.

        Parameters
        ----------
        coefficients : (n_coefficients, 3) array
        size : float
            Positive moments turn the outward direction of s towards the normal.

        Returns
        -------
        force : (n_coefficients, 3) array
        stiffness : (3 n_coefficients, 3 n_coefficients) sparse matrix
            Derivative of the force; not symmetric, an end moment has no potential in general.
        """
        a, b = self.across @ coefficients, self.along @ coefficients
        z = np.cross(a, b)
        J, length = np.linalg.norm(z, axis=1), np.linalg.norm(a, axis=1)
        nu = z / J[:, None]
        w = size * self.weights / length
        force = self.across.T @ (w[:, None] * nu)
        # nu' = (1 - nu nu) (a' x b + a x b') / J and (1/|a|)' = -a.a' / |a|^3
        project = (np.eye(3) - nu[:, :, None] * nu[:, None, :]) / J[:, None, None]
        by_across = (
            -project @ _skew(b) - nu[:, :, None] * a[:, None, :] / length[:, None, None] ** 2
        )
        by_along = project @ _skew(a)
        across, along = self._vector_tables
        stiffness = across.T @ (
            _block_diagonal(w[:, None, None] * by_across) @ across
            + _block_diagonal(w[:, None, None] * by_along) @ along
        )
        return force, stiffness.tocsr()


def edge(surface: SplineSurface, direction: str, end: int, reference: np.ndarray) -> Edge:
    """Edge of a surface at the start (0) or end (1) of direction ``"s"`` or ``"t"``.

    Parameters
    ----------
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.

    Raises
    ------
    ValueError
        Triangles, or if no element touches that edge (a restriction elsewhere, a periodic
        direction).
    """
    if not isinstance(surface, TensorSurface):
        raise ValueError("only splines have edges named by direction: use shells.edge_load")
    x, w = unit_gauss(surface.degree + 1)
    fixed = np.full_like(x, float(end))
    xi, eta = (fixed, x) if direction == "s" else (x, fixed)
    es, et = np.divmod(surface.selected, surface.t.n_elements)
    place, space = (es, surface.s) if direction == "s" else (et, surface.t)
    on_edge = np.repeat(place == (space.n_elements - 1) * end, x.size)
    if not on_edge.any() or space.periodic:
        raise ValueError(f"no element has an edge at the {('start', 'end')[end]} of {direction!r}")
    value, d_s, d_t = (surface.sample(xi, eta, k)[on_edge] for k in (None, 0, 1))
    across, along = (d_s, d_t) if direction == "s" else (d_t, d_s)
    # the normal of Edge.moment is across x along: keep it that of the surface
    if direction == "t":
        across, along = across, -along
    length = np.linalg.norm(along @ reference, axis=1)
    return Edge(value, across, along, np.tile(w, value.shape[0] // x.size) * length)


def _skew(v: np.ndarray) -> np.ndarray:
    """Matrices of ``u -> v x u``, ``(n, 3, 3)``."""
    out = np.zeros((v.shape[0], 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return out - np.swapaxes(out, 1, 2)


def _block_diagonal(blocks: np.ndarray) -> csr_matrix:
    """Sparse block-diagonal matrix of ``(n, 3, 3)`` blocks."""
    n = blocks.shape[0]
    return bsr_matrix((blocks, np.arange(n), np.arange(n + 1)), shape=(3 * n, 3 * n)).tocsr()
