"""The domain cut along element edges into a Navier-Stokes and a Stokes part, sharing velocities.

Each part is a flow problem of its own whose interface G is left natural: residuals of both parts
on G are the tractions that must cancel [T 7.3b]. Pressures are double-valued on G, as in
[T lemma 44]: a continuous pressure would not split. `solve_monolithic` solves both parts at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_array, csc_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from skfem import Mesh

from ..navier_stokes.flow import MixedFlow, Profile, mixed_flow
from ..navier_stokes.spaces import FlowSpace

INTERFACE = "interface"


@dataclass(frozen=True)
class Parts:
    """Both parts and how their interface unknowns correspond.

    Parameters
    ----------
    inner : MixedFlow
        Navier-Stokes part.
    outer : MixedFlow
        Stokes part.
    inner_trace, outer_trace : (m,) int arrays
        Free velocity unknowns on G in each part, in the same order.
    """

    inner: MixedFlow
    outer: MixedFlow
    inner_trace: np.ndarray
    outer_trace: np.ndarray


def cut(
    mesh: Mesh,
    flagged: np.ndarray,
    dirichlet: Mapping[str, Profile],
    *,
    reynolds: float,
    outlet: str,
    stress: bool = True,
) -> Parts:
    """Cut a mesh into parts for partitioned solvers.

    Parameters
    ----------
    mesh : skfem.Mesh
        With named boundaries.
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    dirichlet : mapping
        See `mixed_flow`.
    reynolds : float
    outlet : str
        Boundary without traction.
    stress : bool
        Full stress, the better transmission condition: its iterations contract faster, and both
        sides' tractions are physical.

    Returns
    -------
    Parts

    Raises
    ------
    ValueError
        One part is empty, G touches the outlet, or a Navier-Stokes piece has no outlet.
    """
    check_partition(mesh, flagged, outlet)

    def problem(part: np.ndarray) -> MixedFlow:
        piece = submesh(mesh, part)
        named = {k: v for k, v in dirichlet.items() if k in piece.boundaries}
        out = outlet if outlet in piece.boundaries else None
        return mixed_flow(piece, named, reynolds=reynolds, outlet=out, stress=stress)

    inner, outer = problem(flagged), problem(~flagged)
    unknowns = interface_unknowns(inner), interface_unknowns(outer)
    return Parts(inner, outer, *match_unknowns(*unknowns, inner.space, outer.space))


def check_partition(mesh: Mesh, flagged: np.ndarray, outlet: str) -> None:
    """Refuse partitions that partitioned solvers cannot solve, see `cut`."""
    if flagged.all() or not flagged.any():
        raise ValueError("a partition has Navier-Stokes and Stokes elements; one part is empty")
    stokes_corners = np.unique(mesh.t[:, ~flagged])
    if np.isin(mesh.facets[:, mesh.boundaries[outlet]], stokes_corners).any():
        raise ValueError(
            f"the interface touches the outflow {outlet!r}: partitioned solvers need all elements "
            "there in the Navier-Stokes part; flag them"
        )
    labels = label_pieces(mesh, flagged)
    owners = mesh.f2t[0, mesh.boundaries[outlet]]
    if stranded := sorted(set(labels[flagged]) - set(labels[owners])):
        raise ValueError(
            f"{len(stranded)} Navier-Stokes piece(s) without outflow: partitioned solvers leave "
            "their pressure undetermined; unflag them or connect them to the outflow"
        )


def label_pieces(mesh: Mesh, part: np.ndarray) -> np.ndarray:
    """Number of the piece, connected through edges, of each element of a part; -1 for others."""
    left, right = mesh.f2t
    both = (right >= 0) & part[left] & part[right]
    graph = csr_array((np.ones(both.sum()), (left[both], right[both])), shape=(part.size,) * 2)
    return np.where(part, connected_components(graph, directed=False)[1], -1)


def connect_to_outlet(mesh: Mesh, flagged: np.ndarray, outlet: str) -> np.ndarray:
    """Join every Navier-Stokes piece to the outflow by the shortest chain of elements.

    Boundary elements do not see the pressure level of a piece enclosed by Stokes flow.

    Parameters
    ----------
    mesh : skfem.Mesh
        With named boundaries.
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    outlet : str

    Returns
    -------
    (n_elements,) bool array
    """
    flagged = flagged.copy()
    owners = mesh.f2t[0, mesh.boundaries[outlet]]
    flagged[owners] = True
    left, right = mesh.f2t
    inside = right >= 0
    n = flagged.size
    graph = csr_array((np.ones(inside.sum()), (left[inside], right[inside])), shape=(n, n))
    while True:
        labels = label_pieces(mesh, flagged)
        main = flagged & (labels == labels[owners[0]])
        if (main == flagged).all():
            return flagged
        distance, previous, _ = dijkstra(
            graph, directed=False, indices=np.flatnonzero(main),
            return_predecessors=True, min_only=True,
        )  # fmt: skip
        other = np.flatnonzero(flagged & ~main)
        element = other[np.argmin(distance[other])]
        while element >= 0:
            flagged[element] = True
            element = previous[element]


def submesh(mesh: Mesh, part: np.ndarray) -> Mesh:
    """Submesh with its share of the named boundaries and, as one more, the interface."""
    piece = mesh.restrict(np.flatnonzero(part))
    named = {k: v for k, v in (piece.boundaries or {}).items() if len(v)}
    old = np.concatenate([np.zeros(0, dtype=int), *named.values()])
    named[INTERFACE] = np.setdiff1d(piece.boundary_facets(), old)
    return type(piece)(piece.p, piece.t).with_boundaries(named)


def interface_unknowns(flow: MixedFlow) -> np.ndarray:
    """Free velocity unknowns on the interface: first components, then second ones."""
    dofs = flow.space.velocity.get_dofs(INTERFACE).flatten()
    both = np.concatenate([dofs, dofs + flow.space.n_velocity])
    return both[~flow.fixed[both]]


def match_unknowns(
    a: np.ndarray, b: np.ndarray, first: FlowSpace, second: FlowSpace
) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns of two spaces at the same places, in one order."""
    size = a.size // 2
    halves = []
    for k in range(2):
        part_a, part_b = a[k * size : (k + 1) * size], b[k * size : (k + 1) * size]
        distance, index = cKDTree(second.points[:, part_b].T).query(first.points[:, part_a].T)
        if part_a.size != part_b.size or distance.max(initial=0.0) > 1e-9:
            raise ValueError("the parts' velocity unknowns on the interface do not match")
        halves.append((part_a, part_b[index]))
    return np.concatenate([h[0] for h in halves]), np.concatenate([h[1] for h in halves])


@dataclass(frozen=True)
class MonolithicSolution:
    """Fields of both parts, solved at once.

    Parameters
    ----------
    inner, outer : arrays
        Fields of both parts.
    residual : float
        Norm over the free unknowns.
    iterations : int
    """

    inner: np.ndarray
    outer: np.ndarray
    residual: float
    iterations: int


def solve_monolithic(
    parts: Parts, *, tolerance: float = 1e-13, max_iterations: int = 25
) -> MonolithicSolution:
    """Solve both parts at once by Newton's method, started from rest.

    Parameters
    ----------
    parts : Parts
    tolerance : float
        Norm of the residual below which the iteration stops once it gains no more.
    max_iterations : int

    Returns
    -------
    MonolithicSolution

    Raises
    ------
    ArithmeticError
        No convergence.
    """
    inner, outer = parts.inner, parts.outer
    free = np.concatenate(
        [np.flatnonzero(~inner.fixed), np.flatnonzero(~outer.fixed) + inner.space.n]
    )
    # outer interface unknowns are those of the inner part
    alias = np.arange(inner.space.n + outer.space.n)
    alias[parts.outer_trace + inner.space.n] = parts.inner_trace
    owned = free[alias[free] == free]
    number = np.full(alias.size, -1)
    number[owned] = np.arange(owned.size)
    gather = csr_array(
        (np.ones(free.size), (free, number[alias[free]])), shape=(alias.size, owned.size)
    )
    x = np.concatenate([inner.values, outer.values])
    size = np.inf
    for k in range(max_iterations):
        a, b = x[: inner.space.n], x[inner.space.n :]
        r = np.concatenate([inner.residual(a, inner.everywhere), outer.residual(b, outer.nowhere)])
        r = gather.T @ r
        before, size = size, float(np.linalg.norm(r))
        if size <= tolerance and size > 0.25 * before:
            return MonolithicSolution(a, b, size, k)
        tangent = _block(whole_tangent(inner, a), whole_tangent(outer))
        step = splu(csc_array(gather.T @ tangent @ gather)).solve(r)
        x = x + gather @ step
    raise ArithmeticError(f"the monolithic problem did not converge: residual {size:.1e}")


def whole_tangent(flow: MixedFlow, x: np.ndarray | None = None) -> csr_array:
    """Derivative of N over all unknowns, prescribed ones too; Stokes without ``x``."""
    matrix = csr_array(flow.viscous / flow.reynolds + flow.saddle)
    if x is None:
        return matrix
    rows = np.arange(flow.space.n_elements)
    blocks = flow.convection.matrices(x, rows)
    dofs = flow.space.element_dofs[: blocks.shape[1]].T
    i, j = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return matrix + csr_array((blocks.ravel(), (i.ravel(), j.ravel())), shape=matrix.shape)


def _block(a: csr_array, b: csr_array) -> csr_array:
    return csr_array(block_array([[a, None], [None, b]]))
