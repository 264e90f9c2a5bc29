"""Stokes pieces by boundary elements: velocities on the boundary of a piece to its tractions.

``V t = (1/2 + K) u`` on the polygon of a piece. V maps the normal to zero: the system is bordered
by it, and what the border takes up is the net flux of u.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csr_array

from ..navier_stokes.spaces import FlowSpace
from .boundary_traces import boundary_loops, edge_unknowns, trace, tractions


class BoundaryOperators(Protocol):
    """Planar Stokes operators of a closed polygon, counterclockwise, for unit viscosity.

    Tractions are ordered by segment, end, component ``(4 m,)``; velocities by node and component
    ``(2 m,)``. ``single @ t = double @ u`` for Stokes flows inside, tested with tractions:
    ``double`` is 1/2 + K.
    """

    @property
    def single(self) -> np.ndarray:
        """V, ``(4 m, 4 m)``."""

    @property
    def double(self) -> np.ndarray:
        """1/2 + K, ``(4 m, 2 m)``."""

    def evaluate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Make matrices to velocities inside.

        Parameters
        ----------
        points : (n, 2) array

        Returns
        -------
        (2 n, 4 m) array
            From tractions.
        (2 n, 2 m) array
            From velocities on the boundary.
        """


MakeOperators = Callable[[np.ndarray], BoundaryOperators]


@dataclass(frozen=True)
class Piece:
    """A Stokes piece; u are the ``k`` velocity unknowns of the whole mesh on its boundary.

    Attributes
    ----------
    operators : BoundaryOperators
    unknowns : (k,) int array
    velocity : (2 m, k) sparse array
        To velocities of the polygon's nodes.
    traction : (4 m, k) array
        To tractions at unit viscosity, less the pressure level.
    normal : (4 m,) array
        Traction of a unit tension.
    flux : (k,) array
        Vanishes against every flow that keeps the volume.
    load : (k, 4 m) sparse array
        Tractions against the test functions.
    interior : (i,) int array
        Scalar velocity unknowns of the whole mesh strictly inside.
    """

    operators: BoundaryOperators
    unknowns: np.ndarray
    velocity: csr_array
    traction: np.ndarray
    normal: np.ndarray
    flux: np.ndarray
    load: csr_array
    interior: np.ndarray


def make_piece(
    space: FlowSpace, part: np.ndarray, operators: MakeOperators, segments: int
) -> Piece:
    """A Stokes piece from its elements ``part``, ``(n_elements,)`` flags.

    Raises
    ------
    ValueError
        The piece encloses Navier-Stokes elements.
    """
    loops = boundary_loops(space.mesh, part)
    if len(loops) > 1:
        raise ValueError(
            f"a Stokes piece around {np.round(space.centres[part].mean(axis=0), 3).tolist()} "
            "encloses Navier-Stokes elements, whose pressure boundary elements cannot see: "
            "bridge them"
        )
    corner, following = (space.mesh.p[:, v].T for v in (loops[0], np.roll(loops[0], -1)))
    s = np.arange(segments) / segments
    polygon = (corner[:, None] + s[:, None] * (following - corner)[:, None]).reshape(-1, 2)
    dofs = edge_unknowns(space, corner, following)
    on_loop = np.unique(dofs)
    unknowns = np.concatenate([on_loop, on_loop + space.n_velocity])
    velocity = csr_array(trace(space, dofs, s)[:, unknowns])
    length = np.linalg.norm(following - corner, axis=1)
    made = operators(polygon)
    tangent = (following - corner) / length[:, None]
    normal = np.repeat(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1), 2 * segments, axis=0)
    traction, flux = _dirichlet_to_neumann(made, velocity, normal.ravel())
    return Piece(
        operators=made,
        unknowns=unknowns,
        velocity=velocity,
        traction=traction,
        normal=normal.ravel(),
        flux=flux,
        load=csr_array(tractions(space, dofs, length, segments)[unknowns]),
        interior=np.setdiff1d(np.unique(space.velocity.element_dofs[:, part]), on_loop),
    )


def _dirichlet_to_neumann(
    made: BoundaryOperators, velocity: csr_array, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions without net tension, and the defect that only a net flux leaves."""
    m = normal.size
    bordered = np.zeros((m + 1, m + 1))
    bordered[:m, :m] = made.single
    bordered[:m, m] = bordered[m, :m] = normal
    right = np.zeros((m + 1, velocity.shape[1]))
    right[:m] = (velocity.T @ made.double.T).T
    solution = lu_solve(lu_factor(bordered), right)
    return solution[:m], solution[m]
