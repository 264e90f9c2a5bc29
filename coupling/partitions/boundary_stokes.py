"""The Stokes part by boundary elements: no mesh in it, its boundary only.

On each Stokes piece ``(1/2 + K) u = Re V t`` with the traction t = sigma n on its boundary; on G
the finite elements feel ``-t``. V maps the normal to zero: each piece has a pressure level c as
unknown, and no net flux as its equation. Eliminating t leaves a small dense block on G, solved
with the finite elements at once by Newton. Operators come as matrices for unit viscosity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import block_array, csc_array, csr_array
from scipy.spatial import cKDTree
from skfem import Mesh

from ..model_adaptivity.goals import Goal
from ..navier_stokes.checked_factor import Factor
from ..navier_stokes.flow import MixedFlow, Profile, dirichlet_values, mixed_flow
from ..navier_stokes.spaces import FlowSpace, taylor_hood
from .boundary_pieces import MakeOperators, Piece, make_piece
from .substructure import check_partition, label_pieces, submesh, whole_tangent


@dataclass(frozen=True)
class BoundaryFlow:
    """Navier-Stokes finite elements coupled to Stokes pieces.

    Parameters
    ----------
    inner : MixedFlow
        Navier-Stokes part with natural interface.
    space : FlowSpace
        Of the whole mesh; in the Stokes part only a set of points.
    embed : (n, n_inner) sparse array
        Velocities of the inner part in the whole field.
    values : (n,) array
        Prescribed velocities outside of the inner part.
    pieces : tuple of Piece
    """

    inner: MixedFlow
    space: FlowSpace
    embed: csr_array
    values: np.ndarray
    pieces: tuple[Piece, ...]

    def solve(
        self, start: np.ndarray | None = None, *, tolerance: float = 1e-12, max_iterations: int = 25
    ) -> tuple[np.ndarray, np.ndarray]:
        """Solve both parts at once by Newton's method.

        Parameters
        ----------
        start : (n_inner,) array, optional
            Initial guess; rest otherwise.
        tolerance : float
            Norm of the residual below which the iteration stops once it gains no more.
        max_iterations : int

        Returns
        -------
        (n_inner,) array
            Inner field.
        (n_pieces,) array
            Pressure levels of the pieces.

        Raises
        ------
        ArithmeticError
            Newton's method did not converge.
        """
        inner, free = self.inner, self._free
        x = inner.values.copy() if start is None else np.where(inner.fixed, inner.values, start)
        levels, size = np.zeros(len(self.pieces)), np.inf
        for _ in range(max_iterations):
            u = self.embed @ x + self.values
            r = inner.residual(x, inner.everywhere)
            r = r - self.embed.T @ (self._stiffness @ u + self._level @ levels)
            r = np.concatenate([r[free], -(self._flux @ u)])
            before, size = size, float(np.linalg.norm(r))
            if size <= tolerance and size > 0.25 * before:
                return x, levels
            step = self._factor(whole_tangent(inner, x)).solve(r)
            x[free] += step[: free.size]
            levels = levels + step[free.size :]
        raise ArithmeticError(f"finite and boundary elements: Newton stalled, residual {size:.1e}")

    def adjoint(self, goal: Goal, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Solve the adjoint of the mixed model, without a mesh in the pieces.

        Stokes flow is its own adjoint, hence the same boundary equations.

        Parameters
        ----------
        goal : Goal
            Of the inner field.
        x : (n_inner,) array
            Where the model is linearised.

        Returns
        -------
        (n_inner,) array
            Inner field.
        (n_pieces,) array
            Pressure levels of the pieces.
        """
        inner, free = self.inner, self._free
        right = np.zeros(free.size + len(self.pieces))
        right[: free.size] = goal.derivative(x)[free]
        found = self._factor(csr_array(whole_tangent(inner, x).T)).solve(right)
        z = np.zeros(inner.space.n)
        z[free] = found[: free.size]
        return z, found[free.size :]

    def field(self, x: np.ndarray, levels: np.ndarray, *, prescribed: bool = True) -> np.ndarray:
        """Evaluate velocities at all nodes, in pieces by the representation formula.

        Parameters
        ----------
        x, levels : arrays
            Of `solve` or `adjoint`.
        prescribed : bool
            With the prescribed velocities; not for adjoints, which vanish there.

        Returns
        -------
        (n,) array
        """
        whole = self.embed @ x + (self.values if prescribed else 0.0)
        n, re = self.space.n_velocity, self.inner.reynolds
        for piece, level in zip(self.pieces, levels, strict=True):
            u = whole[piece.unknowns]
            t = piece.traction @ u + re * level * piece.normal
            points = self.space.velocity.doflocs[:, piece.interior].T
            single, double = piece.operators.evaluate(points)
            inside = single @ t + double @ (piece.velocity @ u)
            whole[piece.interior], whole[piece.interior + n] = inside.reshape(-1, 2).T
        return whole

    @cached_property
    def _free(self) -> np.ndarray:
        """Free inner unknowns, those on G last: their block is dense."""
        order = self.inner.pattern.order
        on_boundary = np.zeros(self.space.n, dtype=bool)
        on_boundary[np.concatenate([p.unknowns for p in self.pieces])] = True
        late = (self.embed.T @ on_boundary.astype(float))[order] > 0.0
        return np.concatenate([order[~late], order[late]])

    @cached_property
    def _stiffness(self) -> csr_array:
        """Force of the pieces' tractions for velocities on their boundaries, ``(n, n)``."""
        n = self.space.n
        total = csr_array((n, n))
        for p in self.pieces:
            block = p.load @ p.traction / self.inner.reynolds
            i, j = np.meshgrid(p.unknowns, p.unknowns, indexing="ij")
            total = total + csr_array((block.ravel(), (i.ravel(), j.ravel())), shape=(n, n))
        return total

    @cached_property
    def _level(self) -> csr_array:
        return self._columns([p.load @ p.normal for p in self.pieces])

    @cached_property
    def _flux(self) -> csr_array:
        return csr_array(self._columns([p.flux for p in self.pieces]).T)

    def _columns(self, columns: list[np.ndarray]) -> csr_array:
        rows = np.concatenate([p.unknowns for p in self.pieces])
        number = np.repeat(np.arange(len(self.pieces)), [p.unknowns.size for p in self.pieces])
        shape = (self.space.n, len(self.pieces))
        return csr_array((np.concatenate(columns), (rows, number)), shape=shape)

    def _factor(self, tangent: csr_array) -> Factor:
        free, embed = self._free, self.embed
        stiff = (tangent + embed.T @ self._stiffness @ embed)[free][:, free]
        level = (embed.T @ self._level)[free]
        flux = (self._flux @ embed)[:, free]
        return Factor(csc_array(block_array([[stiff, level], [flux, None]])))


def boundary_flow(
    mesh: Mesh,
    flagged: np.ndarray,
    dirichlet: Mapping[str, Profile],
    operators: MakeOperators,
    *,
    reynolds: float,
    outlet: str,
    segments: int = 2,
) -> BoundaryFlow:
    """Couple finite elements on the flagged part to boundary elements on the others.

    Parameters
    ----------
    mesh : skfem.Mesh
        With named boundaries.
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    dirichlet : mapping
        See `mixed_flow`.
    operators : callable
        Vertices ``(m, 2)`` of a closed polygon, counterclockwise, to its `BoundaryOperators`.
    reynolds : float
    outlet : str
        Boundary without traction.
    segments : int
        Boundary elements on an edge of the mesh.

    Returns
    -------
    BoundaryFlow

    Raises
    ------
    ValueError
        See `cut`; and a Stokes piece that encloses Navier-Stokes elements.
    """
    check_partition(mesh, flagged, outlet)
    space = taylor_hood(mesh)
    part = submesh(mesh, flagged)
    named = {k: v for k, v in dirichlet.items() if k in part.boundaries}
    inner = mixed_flow(part, named, reynolds=reynolds, outlet=outlet, stress=True)
    embed = _embedding(inner.space, space)
    held = np.zeros(space.n, dtype=bool)
    held[embed.nonzero()[0]] = True
    values = np.where(held, 0.0, dirichlet_values(space, dirichlet)[1])
    labels = label_pieces(mesh, ~flagged)
    pieces = [
        make_piece(space, labels == k, operators, segments) for k in np.unique(labels[labels >= 0])
    ]
    return BoundaryFlow(inner, space, embed, values, tuple(pieces))


def _embedding(inner: FlowSpace, whole: FlowSpace) -> csr_array:
    """Velocities (not pressures) of a submesh's field in the field of the mesh."""
    distance, index = cKDTree(whole.velocity.doflocs.T).query(inner.velocity.doflocs.T)
    if distance.max() > 1e-9:
        raise ValueError("the inner mesh is not a part of the whole one")
    rows = np.concatenate([index, index + whole.n_velocity])
    columns = np.arange(2 * inner.n_velocity)
    return csr_array((np.ones(rows.size), (rows, columns)), shape=(whole.n, inner.n))
