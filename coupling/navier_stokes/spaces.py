"""Taylor-Hood spaces on scikit-fem: Q2-Q1 on quadrilaterals, P2-P1 (P3-P2) on triangles.

A field is one vector: first velocity components, second ones, pressures. Both components share
a scalar scikit-fem basis, so that every table and pattern exists once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skfem import (
    Basis,
    CellBasis,
    ElementQuad1,
    ElementQuad2,
    ElementTriP1,
    ElementTriP2,
    ElementTriP3,
    Mesh,
    MeshQuad,
)

# The elements of a pair and the polynomial degree that integrates its convection exactly.
_PAIRS: Mapping[tuple[bool, int], tuple] = {
    (True, 2): (ElementQuad2, ElementQuad1, 7),
    (False, 2): (ElementTriP2, ElementTriP1, 5),
    (False, 3): (ElementTriP3, ElementTriP2, 8),
}

CHUNK = 500


@dataclass(frozen=True)
class FlowSpace:
    """Velocity and pressure on one mesh.

    Parameters
    ----------
    velocity, pressure : skfem.CellBasis
        Scalar bases on the same quadrature points.
    degree : int
        Polynomial degree of the velocity.
    """

    velocity: CellBasis
    pressure: CellBasis
    degree: int

    @property
    def mesh(self) -> Mesh:
        """Mesh of both bases."""
        return self.velocity.mesh

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.mesh.t.shape[1]

    @property
    def n_velocity(self) -> int:
        """Unknowns of one velocity component."""
        return self.velocity.N

    @property
    def n(self) -> int:
        """Number of unknowns: both velocity components and the pressure."""
        return 2 * self.velocity.N + self.pressure.N

    @cached_property
    def element_dofs(self) -> np.ndarray:
        """Unknowns of each element, ``(k, n_elements)``: both components, then pressures."""
        u, p = self.velocity.element_dofs, self.pressure.element_dofs
        return np.concatenate([u, u + self.n_velocity, p + 2 * self.n_velocity])

    @cached_property
    def points(self) -> np.ndarray:
        """Place of each unknown, ``(2, n)``."""
        u, p = self.velocity.doflocs, self.pressure.doflocs
        return np.concatenate([u, u, p], axis=1)

    @cached_property
    def centres(self) -> np.ndarray:
        """Element centres ``(n_elements, 2)``."""
        return self.mesh.p[:, self.mesh.t].mean(axis=1).T

    @cached_property
    def volumes(self) -> np.ndarray:
        """Areas of the elements ``(n_elements,)``."""
        return self.velocity.dx.sum(axis=1)

    def split(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """View a field as both velocity components and the pressure.

        Parameters
        ----------
        x : (n,) array

        Returns
        -------
        tuple of arrays
        """
        n = self.n_velocity
        return x[:n], x[n : 2 * n], x[2 * n :]

    def nodal(self, other: FlowSpace, x: np.ndarray) -> np.ndarray:
        """Evaluate a field of another space on the same mesh at this space's nodes.

        Parameters
        ----------
        other : FlowSpace
        x : array
            Field of the other space.

        Returns
        -------
        (n,) array
        """
        parts = zip(self.split(np.empty(self.n)), other.split(x), "uup", strict=True)
        bases = {"u": (self.velocity, other.velocity), "p": (self.pressure, other.pressure)}
        return np.concatenate([_nodal(part, values, *bases[k]) for part, values, k in parts])

    def transfer(self, other: FlowSpace, x: np.ndarray) -> np.ndarray:
        """Evaluate a field on another mesh of the same domain at this space's nodes.

        Parameters
        ----------
        other : FlowSpace
        x : array
            Field of the other space.

        Returns
        -------
        (n,) array
        """
        ux, uy, p = other.split(x)
        velocity = _at(other.velocity, np.stack([ux, uy], axis=1), self.velocity.doflocs)
        pressure = _at(other.pressure, p, self.pressure.doflocs)
        return np.concatenate([velocity[:, 0], velocity[:, 1], pressure])


def _at(basis: CellBasis, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Fields at points, some points at a time: the search may try every element for each."""
    parts = np.array_split(points, max(1, points.shape[1] // CHUNK), axis=1)
    return np.concatenate([basis.probes(part) @ values for part in parts])


def _nodal(result: np.ndarray, x: np.ndarray, to: CellBasis, source: CellBasis) -> np.ndarray:
    nodes = to.elem.doflocs.T
    phi = np.array([source.elem.lbasis(nodes, i)[0] for i in range(source.Nbfun)])
    result[to.element_dofs] = np.einsum("ik,ie->ke", phi, x[source.element_dofs])
    return result


def taylor_hood(mesh: Mesh, degree: int = 2) -> FlowSpace:
    """Make the stable pair of a mesh.

    Parameters
    ----------
    mesh : skfem.MeshQuad or skfem.MeshTri
    degree : int
        2, or 3 on triangles (the enriched dual of mesh adaptivity).

    Returns
    -------
    FlowSpace

    Raises
    ------
    ValueError
        No such pair.
    """
    key = (isinstance(mesh, MeshQuad), degree)
    if key not in _PAIRS:
        raise ValueError(f"no Taylor-Hood pair of degree {degree} on {type(mesh).__name__}")
    u, p, order = _PAIRS[key]
    velocity = Basis(mesh, u(), intorder=order)
    return FlowSpace(velocity, velocity.with_element(p()), degree)
