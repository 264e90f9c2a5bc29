"""The wet boundary as a polygon: nodes of a C1 membrane, then of a fixed inlet [T 4.27].

Counterclockwise and closed. Velocities are linear between nodes, tractions linear on each
segment and free to jump; loads are tested with the membrane's own Hermite functions. The influx
follows the membrane's discrete flux, so that the total discrete flux vanishes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, kron

from . import _crossing_kernels as crossings
from . import _planar_kernels as kernels

FACING = -0.9  # cosine between facing normals: the walls of a fold tip do not count


@dataclass(frozen=True)
class OuterRule:
    """Points of the outer integrals: Gauss far away, graded at projections when near.

    Parameters
    ----------
    far : int
        Gauss points of a segment.
    near : int
        Points of the graded rule; 0 switches it off.

    Notes
    -----
    Measured on a squeeze film of element/gap 100: load
    error 1e-4 with (6, 16), 5e-3 with (8, 14), 9e-2 with (4, 14).
    """

    far: int = 6
    near: int = 16

    @cached_property
    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Far and near points and weights on [0, 1]."""
        return (*gauss(self.far), *graded(self.near))


def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre points and weights on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1.0), 0.5 * w


def graded(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points under ``s = x^3 (10 - 15 x + 6 x^2)``: graded to both ends."""
    if n == 0:
        return np.empty(0), np.empty(0)
    x, w = gauss(n)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2), w * 30.0 * (x * (1.0 - x)) ** 2


def edges(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths ``(n,)`` and outward normals ``(n, 2)`` of a counterclockwise polygon's segments."""
    edge = np.roll(points, -1, axis=0) - points
    lengths = np.linalg.norm(edge, axis=1)
    return lengths, np.stack([edge[:, 1], -edge[:, 0]], axis=1) / lengths[:, None]


def tested(lengths: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Discontinuous linear values ``(2 n, ...)`` tested with themselves: the mass matrix."""
    pairs = values.reshape(lengths.size, 2, -1)
    block = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    return np.einsum("e,mk,ekc->emc", lengths, block, pairs).reshape(values.shape)


def crossing(points: np.ndarray) -> tuple[int, int] | None:
    """Two segments of a closed polygon that cross.

    Parameters
    ----------
    points : (n, 2) array
        Nodes in order; the last one is joined to the first.

    Returns
    -------
    tuple of two ints, or None
    """
    i, j = crossings.first_crossing(np.ascontiguousarray(points, dtype=float))
    return None if i < 0 else (i, j)


def meeting(before: np.ndarray, after: np.ndarray) -> tuple[int, int] | None:
    """A node and a segment that meet while a closed polygon's nodes move straight.

    Exact, so that walls which pass each other within the motion are seen.

    Parameters
    ----------
    before, after : (n, 2) array
        Nodes in order.

    Returns
    -------
    tuple of two ints, or None
    """
    arrays = (np.ascontiguousarray(points, dtype=float) for points in (before, after))
    i, j = crossings.first_meeting(*arrays)
    return None if i < 0 else (i, j)


def smallest_gap(points: np.ndarray) -> float:
    """Smallest distance between facing segments of a closed polygon.

    Parameters
    ----------
    points : (n, 2) array
        Nodes in order; the last one is joined to the first.

    Returns
    -------
    float
        Infinite if none face each other.
    """
    return float(kernels.facing_gap(np.ascontiguousarray(points, dtype=float), FACING))


@dataclass(frozen=True)
class Boundary:
    """What does not change while the membrane moves.

    Parameters
    ----------
    arc_lengths : (n_membrane + 1,) array
        Of the membrane's nodes; it runs counterclockwise from the inlet's far end to its near one.
    inlet : (n_inlet - 1, 2) array
        Nodes strictly inside the fixed inlet, in the same sense.
    profile : (n_inlet - 1,) array
        Inflow profile X at those nodes; it vanishes at the inlet's ends [T 4.30b].

    Raises
    ------
    ValueError
        Arrays that do not fit, or an inlet without an inner node.
    """

    arc_lengths: np.ndarray
    inlet: np.ndarray
    profile: np.ndarray

    def __post_init__(self) -> None:
        if self.inlet.ndim != 2 or self.inlet.shape[1] != 2 or self.inlet.shape[0] < 1:
            raise ValueError("the inlet needs at least one inner node, an (n, 2) array")
        if self.profile.shape != self.inlet.shape[:1]:
            raise ValueError(f"expected {self.inlet.shape[0]} profile values")
        if not self.profile.sum() > 0.0:
            raise ValueError("the inflow profile must have a positive integral")

    @property
    def n_membrane(self) -> int:
        """Segments of the membrane."""
        return self.arc_lengths.size - 1

    @property
    def n_coefficients(self) -> int:
        """Rows of a configuration: positions and slopes by turns."""
        return 2 * self.arc_lengths.size

    @property
    def n_segments(self) -> int:
        """Segments of membrane and inlet."""
        return self.n_membrane + self.inlet.shape[0] + 1

    @cached_property
    def trace(self) -> csr_matrix:
        """Nodal values to discontinuous linear ones, scalar ``(2 n, n)``."""
        n = self.n_segments
        columns = (np.repeat(np.arange(n), 2) + np.tile([0, 1], n)) % n
        return csr_matrix((np.ones(2 * n), (np.arange(2 * n), columns)), (2 * n, n))

    @cached_property
    def vector_trace(self) -> csr_matrix:
        """The same for both components, ``(4 n, 2 n)``."""
        return kron(self.trace, np.eye(2), format="csr")

    @cached_property
    def tests(self) -> np.ndarray:
        """Integrals of Hermite times linear functions on [0, 1], ``(n_membrane, 4, 2)``."""
        xi, w = gauss(4)
        h = np.diff(self.arc_lengths)
        cubic = np.broadcast_to(_cubics(xi), (h.size, xi.size, 4)).copy()
        cubic[:, :, 1::2] *= h[:, None, None]
        linear = np.stack([1.0 - xi, xi], axis=1)
        return np.einsum("eqa,qm,q->eam", cubic, linear, w)

    def at(self, coefficients: np.ndarray) -> Configuration:
        """The polygon of a configuration.

        Parameters
        ----------
        coefficients : (n_coefficients, 2) array

        Returns
        -------
        Configuration
        """
        points = np.concatenate([coefficients[::2], self.inlet])
        return Configuration(self, np.ascontiguousarray(points))


def _cubics(xi: np.ndarray) -> np.ndarray:
    """Hermite cubics of an element of length 1, ``(n, 4)``."""
    return np.stack(
        [
            1.0 - xi**2 * (3.0 - 2.0 * xi),
            xi * (1.0 - xi) ** 2,
            xi**2 * (3.0 - 2.0 * xi),
            xi**2 * (xi - 1.0),
        ],
        axis=-1,
    )


@dataclass(frozen=True)
class Configuration:
    """One polygon and the maps that live on it.

    Attributes
    ----------
    boundary : Boundary
    points : (n, 2) array
        Nodes; segment e joins node e to the next.
    """

    boundary: Boundary
    points: np.ndarray
    lengths: np.ndarray = field(init=False)
    normals: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        lengths, normals = edges(self.points)
        object.__setattr__(self, "lengths", lengths)
        object.__setattr__(self, "normals", normals)

    @cached_property
    def unit_influx(self) -> np.ndarray:
        """Nodal velocities ``(n, 2)`` of a unit influx through the inlet."""
        b, values = self.boundary, np.zeros_like(self.points)
        first = b.n_membrane
        # the inlet is straight: all of its segments share one normal
        values[first + 1 :] = -b.profile[:, None] * self.normals[first]
        inner = values + np.roll(values, -1, axis=0)
        flux = 0.5 * np.einsum("e,ei,ei->", self.lengths, self.normals, inner)
        return values / -flux

    @cached_property
    def flux_form(self) -> np.ndarray:
        """The membrane's discrete flux, a linear form of the velocity: ``(n_coefficients, 2)``."""
        n = self.boundary.n_membrane
        half = 0.5 * (self.lengths[:, None] * self.normals)[:n]
        form = np.zeros((self.boundary.n_coefficients, 2))
        form[0:-2:2] += half
        form[2::2] += half
        return form

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of a velocity ``(n_coefficients, 2)`` out through the membrane."""
        return float(np.sum(self.flux_form * velocity))

    def nodal_velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Dirichlet data at the nodes ``(n, 2)``, influx included."""
        nodal = self.flux(velocity) * self.unit_influx
        nodal[: self.boundary.n_membrane + 1] += velocity[::2]
        return nodal

    @cached_property
    def nodal_matrix(self) -> np.ndarray:
        """`nodal_velocity` as ``(2 n, 2 (n_membrane + 1))`` acting on the membrane's nodes."""
        m = 2 * (self.boundary.n_membrane + 1)
        matrix = np.outer(self.unit_influx.ravel(), self.flux_form[::2].ravel())
        matrix[np.arange(m), np.arange(m)] += 1.0
        return matrix

    @cached_property
    def testing(self) -> csr_matrix:
        """``int rho N ds``: discontinuous linear on the membrane to scalar tested values."""
        b = self.boundary
        n = b.n_membrane
        data = self.lengths[:n, None, None] * b.tests
        rows = 2 * np.arange(n)[:, None, None] + np.arange(4)[:, None] + np.zeros((1, 1, 2), int)
        columns = 2 * np.arange(n)[:, None, None] + np.arange(2) + np.zeros((1, 4, 1), int)
        shape = (b.n_coefficients, 2 * b.n_segments)
        return csr_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape)
