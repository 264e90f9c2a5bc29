"""Constraints on coefficients as one sparse extraction E: ``dc = E dq``.

Poles, supports and symmetry planes all become columns of E; assembly runs on full coefficients
and is reduced by ``E^T . E``. Vector dof ``3 a + c`` is component c of coefficient a.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, identity, kron, vstack
from scipy.sparse.csgraph import connected_components

from ..surfaces.spline_surface import SplineSurface
from ..surfaces.surface import Surface


def vector_dofs(rows: np.ndarray, components: Iterable[int] = (0, 1, 2)) -> np.ndarray:
    """Vector dofs of some components of coefficients ``rows``."""
    return (3 * np.asarray(rows)[:, None] + np.array(list(components))).ravel()


def extraction(
    reduction: csr_matrix,
    fixed: np.ndarray | None = None,
    n_fixed_rows: int = 0,
    ties: tuple[np.ndarray, np.ndarray] | None = None,
) -> csr_matrix:
    """Extraction E of a surface from its fixed and tied dofs.

    Parameters
    ----------
    reduction : (n_coefficients, n_dofs) sparse matrix
        Scalar extraction of the surface (`SplineSurface.reduction`).
    fixed : int array, optional
        Vector dofs that do not move.
    n_fixed_rows : int
        Further coefficients after the surface's own that never move (an inlet).
    ties : (tied, leaders), optional
        Vector dofs that move as others do (see `symmetry`).

    Returns
    -------
    (3 (n_coefficients + n_fixed_rows), n_free) sparse matrix

    Raises
    ------
    ValueError
        A fixed dof that shares its pole dofs with free ones, or nothing left free.
    """
    full = kron(reduction, identity(3), format="csr")
    if ties is not None:
        source = np.arange(full.shape[0])
        source[ties[0]] = ties[1]
        full = full[source]
        full = full[:, np.unique(full.indices)]
    if fixed is not None and fixed.size:
        column_hits = np.unique(full[fixed].indices)
        touched = full[:, column_hits].tocsr()
        others = np.setdiff1d(np.flatnonzero(np.diff(touched.indptr)), fixed)
        if others.size:
            raise ValueError("cannot fix single coefficients of a pole: fix both of its rings")
        keep = np.setdiff1d(np.arange(full.shape[1]), column_hits)
        full = full[:, keep]
    if full.shape[1] == 0:
        raise ValueError("the supports leave nothing free to move")
    if n_fixed_rows:
        full = vstack([full, csr_matrix((3 * n_fixed_rows, full.shape[1]))], format="csr")
    return full


def rim(surface: SplineSurface, ring: int, kind: str) -> np.ndarray:
    """Vector dofs that hold a rim: its trace if hinged, also the next ring if clamped.

    Raises
    ------
    ValueError
        A kind other than ``"hinged"`` or ``"clamped"``.
    """
    if kind not in ("hinged", "clamped"):
        raise ValueError(f"a rim is 'hinged' or 'clamped', not {kind!r}")
    rings = [ring] if kind == "hinged" else [ring, ring - 1 if ring < 0 else ring + 1]
    return np.concatenate([vector_dofs(surface.ring(r)) for r in rings])


@dataclass(frozen=True)
class Support:
    """Vector dofs that do not move, and pairs that move alike (see `supported`)."""

    fixed: np.ndarray
    tied: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=int))
    leaders: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=int))


NO_GRID = (
    "only a SplineSurface has edges named by direction and end: triangles take shells.rim_edges "
    "and shells.hold_edges"
)


def _row(surface: SplineSurface, direction: str, end: int, layer: int = 0) -> np.ndarray:
    if direction not in ("s", "t") or end not in (0, 1):
        raise ValueError(f"an edge is 's' or 't' at end 0 or 1, not {direction!r} at {end!r}")
    if not isinstance(surface, SplineSurface):
        raise ValueError(NO_GRID)
    pick = surface.ring if direction == "s" else surface.column
    row = pick(layer if end == 0 else -1 - layer)
    if row.size == 0:
        raise ValueError(f"no element of the surface touches edge {direction} at end {end}")
    return row


def hinge(
    surface: SplineSurface, direction: str, end: int, components: Iterable[int] = (0, 1, 2)
) -> Support:
    """Hold some components of an edge; it may turn.

    Parameters
    ----------
    surface : SplineSurface
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
        Start or end of that direction.
    components : ints
        Cartesian components that are held.

    Returns
    -------
    Support

    Raises
    ------
    ValueError
        An edge that no element of the surface has.
    """
    return Support(vector_dofs(_row(surface, direction, end), components))


def clamp(
    surface: SplineSurface, direction: str, end: int, components: Iterable[int] = (0, 1, 2)
) -> Support:
    """Hold an edge and its slope.

    Parameters
    ----------
    surface : SplineSurface
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
        Start or end of that direction.
    components : ints
        Cartesian components of the second row of coefficients that are held: all of them also
        stop the strain across the edge, the component normal to a flat edge alone does not.

    Returns
    -------
    Support

    Raises
    ------
    ValueError
        An edge that no element of the surface has.
    """
    trace = vector_dofs(_row(surface, direction, end))
    return Support(np.r_[trace, vector_dofs(_row(surface, direction, end, 1), components)])


def pin(surface: Surface, row: int, components: Iterable[int] = (0, 1, 2)) -> Support:
    """Hold components of one coefficient: removes rigid motions that no load excites.

    Parameters
    ----------
    surface : Surface
    row : int
        The coefficient.
    components : ints
        Cartesian components that are held.

    Returns
    -------
    Support
    """
    return Support(vector_dofs(np.array([row]), components))


def symmetry(surface: SplineSurface, direction: str, end: int, axis: int) -> Support:
    """Symmetry plane ``x_axis = const`` through an edge.

    The trace stays in the plane and the tangent across it stays normal to the plane: component
    ``axis`` of the first row is fixed, the others are those of the second row.

    Parameters
    ----------
    surface : SplineSurface
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
        Start or end of that direction.
    axis : {0, 1, 2}
        Cartesian direction normal to the plane.

    Returns
    -------
    Support

    Raises
    ------
    ValueError
        An edge that no element of the surface has, or one that a restriction leaves ragged.
    """
    trace, following = (_row(surface, direction, end, k) for k in (0, 1))
    if trace.size != following.size:
        raise ValueError(
            f"the restriction is ragged along edge {direction} at end {end}: a symmetry plane "
            "needs whole columns of two elements there"
        )
    along = [c for c in range(3) if c != axis]
    return Support(
        vector_dofs(trace, (axis,)), vector_dofs(following, along), vector_dofs(trace, along)
    )


def supported(surface: Surface, *supports: Support) -> csr_matrix:
    """Extraction E of a surface under any supports; they may meet in corners.

    Dofs tied to each other, over any number of ties, move as one; one fixed dof fixes all of them.

    Parameters
    ----------
    surface : Surface
    *supports : Support
        Of `clamp`, `hinge`, `pin` and `symmetry`; on triangles of `hold_edges` and `pin`.

    Returns
    -------
    (3 n_coefficients, n_free) sparse matrix

    Raises
    ------
    ValueError
        A fixed dof that shares its pole dofs with free ones, or nothing left free.
    """
    n = 3 * surface.n_coefficients
    fixed, tied, leaders = (
        np.concatenate([np.empty(0, dtype=int), *(getattr(s, name) for s in supports)])
        for name in ("fixed", "tied", "leaders")
    )
    graph = coo_matrix((np.ones(tied.size), (tied, leaders)), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    held = np.flatnonzero(np.isin(group, group[fixed]))
    first = np.unique(group, return_index=True)[1][group]
    moved = np.setdiff1d(np.flatnonzero(first != np.arange(n)), held)
    return extraction(surface.reduction, held, ties=(moved, first[moved]))
