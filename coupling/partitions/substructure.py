"""The domain cut along element edges into a Navier-Stokes and a Stokes part, sharing velocities.

Each part is a flow problem of its own whose interface G is left natural: residuals of both parts
on G are the tractions that must cancel [T 7.3b]. Pressures are double-valued on G, as in
[T lemma 44]: a continuous pressure would not split. `monolithic` solves both parts at once.
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

    Attributes
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
    dirichlet, reynolds, outlet, stress
        See `mixed_flow`; the full stress is the better transmission condition: its iterations
        contract faster, and both sides' tractions are physical.

    Raises
    ------
    ValueError
        One part is empty, G touches the outlet, or a Navier-Stokes piece has no outlet.
    """
    check_partition(mesh, flagged, outlet)
    problems = []
    for part in (flagged, ~flagged):
        piece = restricted(mesh, part)
        named = {k: v for k, v in dirichlet.items() if k in piece.boundaries}
        out = outlet if outlet in piece.boundaries else None
        problems.append(mixed_flow(piece, named, reynolds=reynolds, outlet=out, stress=stress))
    traces = matching(*(interface_unknowns(p) for p in problems), *(p.space for p in problems))
    return Parts(*problems, *traces)


def check_partition(mesh: Mesh, flagged: np.ndarray, outlet: str) -> None:
    """See `cut`."""
    if flagged.all() or not flagged.any():
        raise ValueError("a partition has Navier-Stokes and Stokes elements; one part is empty")
    stokes_corners = np.unique(mesh.t[:, ~flagged])
    if np.isin(mesh.facets[:, mesh.boundaries[outlet]], stokes_corners).any():
        raise ValueError(
            f"the interface touches the outflow {outlet!r}: partitioned solvers need all elements "
            "there in the Navier-Stokes part; flag them"
        )
    labels = pieces_of(mesh, flagged)
    owners = mesh.f2t[0, mesh.boundaries[outlet]]
    if stranded := sorted(set(labels[flagged]) - set(labels[owners])):
        raise ValueError(
            f"{len(stranded)} Navier-Stokes piece(s) without outflow: partitioned solvers leave "
            "their pressure undetermined; unflag them or connect them to the outflow"
        )


def pieces_of(mesh: Mesh, part: np.ndarray) -> np.ndarray:
    """Number of the piece, connected through edges, of each element of a part; -1 for others."""
    left, right = mesh.f2t
    both = (right >= 0) & part[left] & part[right]
    graph = csr_array((np.ones(both.sum()), (left[both], right[both])), shape=(part.size,) * 2)
    return np.where(part, connected_components(graph, directed=False)[1], -1)


def bridged(mesh: Mesh, flagged: np.ndarray, outlet: str) -> np.ndarray:
    """Flags with every piece joined to the outflow by the shortest chain of elements.

    Boundary elements do not see the pressure level of a piece enclosed by Stokes flow.
    """
    flagged = flagged.copy()
    owners = mesh.f2t[0, mesh.boundaries[outlet]]
    flagged[owners] = True
    left, right = mesh.f2t
    inside = right >= 0
    n = flagged.size
    graph = csr_array((np.ones(inside.sum()), (left[inside], right[inside])), shape=(n, n))
    while True:
        labels = pieces_of(mesh, flagged)
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


def restricted(mesh: Mesh, part: np.ndarray) -> Mesh:
    """Submesh with its share of the named boundaries and, as one more, the interface."""
    piece = mesh.restrict(np.flatnonzero(part))
    named = {k: v for k, v in (piece.boundaries or {}).items() if len(v)}
    old = np.concatenate([np.asarray(v) for v in named.values()]) if named else []
    named[INTERFACE] = np.setdiff1d(piece.boundary_facets(), old)
    return type(piece)(piece.p, piece.t).with_boundaries(named)


def interface_unknowns(flow: MixedFlow) -> np.ndarray:
    """Free velocity unknowns on the interface: first components, then second ones."""
    dofs = flow.space.velocity.get_dofs(INTERFACE).flatten()
    both = np.concatenate([dofs, dofs + flow.space.n_velocity])
    return both[~flow.fixed[both]]


def matching(
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
    return tuple(np.concatenate([h[i] for h in halves]) for i in range(2))


@dataclass(frozen=True)
class Split:
    """Fields of both parts and the residual of the solve."""

    inner: np.ndarray
    outer: np.ndarray
    residual: float
    iterations: int


def monolithic(parts: Parts, *, tolerance: float = 1e-13, max_iterations: int = 25) -> Split:
    """Newton's method for both parts at once, started from rest.

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
            return Split(a, b, size, k)
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
