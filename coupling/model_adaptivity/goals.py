"""Goal quantities: vorticity in a region, weighted traction, kinetic energy, mollified point value.

A goal has a value and a derivative ``J'(u, p)`` as a vector over all unknowns [T 7.19 ff.].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array
from skfem import BilinearForm, LinearForm

from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.spaces import FlowSpace

AREA_TOLERANCE = 1e-9


class Goal(Protocol):
    """A differentiable functional of a field ``(n,)``."""

    def value(self, x: np.ndarray) -> float:
        """Evaluate J.

        Parameters
        ----------
        x : (n,) array

        Returns
        -------
        float
        """

    def derivative(self, x: np.ndarray) -> np.ndarray:
        """Differentiate J.

        Parameters
        ----------
        x : (n,) array

        Returns
        -------
        (n,) array
        """


@dataclass(frozen=True)
class Linear(Goal):
    """``J(x) = g . x``."""

    vector: np.ndarray

    def value(self, x: np.ndarray) -> float:
        return float(self.vector @ x)

    def derivative(self, x: np.ndarray) -> np.ndarray:
        return self.vector


@dataclass(frozen=True)
class Quadratic(Goal):
    """``J(x) = x . M x / 2`` with symmetric M."""

    matrix: csr_array

    def value(self, x: np.ndarray) -> float:
        return 0.5 * float(x @ (self.matrix @ x))

    def derivative(self, x: np.ndarray) -> np.ndarray:
        return self.matrix @ x


@dataclass(frozen=True)
class BoundaryForce(Goal):
    """``J = N((u, p), l(v)) - F(l(v))``: sigma n on a boundary, on the fluid, weighted with v.

    ``lift`` is v on the boundary's nodes and 0 on all others; N is the full model everywhere.
    """

    # departs from [T 7.3, item 2], printed with the opposite sign: N - F is what integration by
    # parts leaves on the Dirichlet boundary

    flow: MixedFlow
    lift: np.ndarray

    def value(self, x: np.ndarray) -> float:
        return -float(self.lift @ self.flow.residual(x, self.flow.everywhere))

    def derivative(self, x: np.ndarray) -> np.ndarray:
        flow = self.flow
        linear = flow.viscous.T @ self.lift / flow.reynolds + flow.saddle.T @ self.lift
        touched = np.isin(flow.space.element_dofs, np.flatnonzero(self.lift)).any(axis=0)
        rows = np.flatnonzero(touched)
        blocks = flow.convection.matrices(x, rows)
        dofs = flow.space.element_dofs[: 2 * flow.space.velocity.Nbfun, rows].T
        part = np.einsum("eij,ei->ej", blocks, self.lift[dofs])
        return linear + np.bincount(dofs.ravel(), part.ravel(), minlength=flow.space.n)


def region(space: FlowSpace, box: tuple[float, float, float, float]) -> np.ndarray:
    """Flag the elements of a rectangle.

    Parameters
    ----------
    space : FlowSpace
    box : tuple of four float
        Left, right, bottom, top.

    Returns
    -------
    (n_elements,) bool array

    Raises
    ------
    ValueError
        The rectangle leaves the domain or cuts elements.
    """
    x, y = space.centres.T
    inside = (x > box[0]) & (x < box[1]) & (y > box[2]) & (y < box[3])
    wanted = (box[1] - box[0]) * (box[3] - box[2])
    found = float(space.volumes[inside].sum())
    corners = space.mesh.p[:, space.mesh.t[:, inside]].reshape(2, -1)
    slack = 1e-9 * max(1.0, np.abs(box).max())
    low, high = np.array(box[0::2])[:, None] - slack, np.array(box[1::2])[:, None] + slack
    cut = bool(((corners < low) | (corners > high)).any())
    if cut or abs(found - wanted) > AREA_TOLERANCE * wanted:
        raise ValueError(
            f"goal region {list(box)}: whole elements cover {found:.6g} of its area {wanted:.6g}"
            f"{' and reach out of it' if cut else ''}; it must lie in the domain, on element edges"
        )
    return inside


def vorticity(space: FlowSpace, elements: np.ndarray) -> Linear:
    """Make the goal ``J = int d_y u_x - d_x u_y`` over flagged elements [T 7.19].

    Parameters
    ----------
    space : FlowSpace
    elements : (n_elements,) bool array

    Returns
    -------
    Goal
    """
    part = space.velocity.with_elements(np.flatnonzero(elements))
    gx, gy = (LinearForm(lambda v, w, i=i: v.grad[i]).assemble(part) for i in range(2))
    return Linear(np.concatenate([gy, -gx, np.zeros(space.pressure.N)]))


def kinetic_energy(space: FlowSpace) -> Quadratic:
    """Make the goal ``J = |u|^2 / 2`` in L2.

    Parameters
    ----------
    space : FlowSpace

    Returns
    -------
    Goal
    """
    mass = csr_array(BilinearForm(lambda u, v, w: u * v).assemble(space.velocity))
    n, p = space.n_velocity, space.pressure.N
    coo = mass.tocoo()
    rows, columns = np.r_[coo.row, coo.row + n], np.r_[coo.col, coo.col + n]
    data = np.r_[coo.data, coo.data]
    return Quadratic(csr_array((data, (rows, columns)), shape=(2 * n + p, 2 * n + p)))


def point_value(
    space: FlowSpace, point: tuple[float, float], radius: float, component: int = 0
) -> Linear:
    """Make the goal of a velocity near a point, weighted by ``exp(-1 / (1 - r^2 / R^2))``.

    Parameters
    ----------
    space : FlowSpace
    point : tuple of two float
    radius : float
        R, where the weight ends.
    component : int
        0 or 1.

    Returns
    -------
    Goal

    Raises
    ------
    ValueError
        No quadrature point lies in the disc: it is outside, or smaller than the elements.
    """
    at = np.asarray(point)

    def weight(x: np.ndarray) -> np.ndarray:
        s = 1.0 - ((x[0] - at[0]) ** 2 + (x[1] - at[1]) ** 2) / radius**2
        return np.where(s > 0.0, np.exp(-1.0 / np.where(s > 0.0, s, 1.0)), 0.0)

    values = LinearForm(lambda v, w: weight(w.x) * v).assemble(space.velocity)
    total = float(values.sum())
    if not total > 0.0:
        raise ValueError(f"no element lies within {radius:g} of the goal's point {list(point)}")
    vector = np.zeros(space.n)
    start = component * space.n_velocity
    vector[start : start + space.n_velocity] = values / total
    return Linear(vector)


def boundary_force(flow: MixedFlow, boundary: str, direction: tuple[float, float]) -> BoundaryForce:
    """Make the goal of a force on a Dirichlet boundary, by the residual of a lift.

    Parameters
    ----------
    flow : MixedFlow
    boundary : str
    direction : tuple of two float

    Returns
    -------
    Goal
    """
    space = flow.space
    dofs = space.velocity.get_dofs(boundary).flatten()
    lift = np.zeros(space.n)
    for i in range(2):
        lift[dofs + i * space.n_velocity] = direction[i]
    return BoundaryForce(flow, lift)
