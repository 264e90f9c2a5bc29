"""Constraints on coefficients as one sparse extraction E: ``dc = E dq``.

Poles, supports and symmetry planes all become columns of E; assembly runs on full coefficients
and is reduced by ``E^T . E``. Vector dof ``3 a + c`` is component c of coefficient a.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_matrix, identity, kron, vstack


def vector_dofs(rows: np.ndarray, components: Iterable[int] = (0, 1, 2)) -> np.ndarray:
    """Vector dofs of some components of coefficients ``rows``."""
    return (3 * np.asarray(rows)[:, None] + np.array(list(components))).ravel()


def extraction(
    reduction: csr_matrix,
    fixed: np.ndarray | None = None,
    n_fixed_rows: int = 0,
    ties: tuple[np.ndarray, np.ndarray] | None = None,
) -> csr_matrix:
    """Extraction ``(3 (n_coefficients + n_fixed_rows), n_free)``.

    Parameters
    ----------
    reduction : (n_coefficients, n_dofs) sparse matrix
        Scalar extraction of the surface (`SplineSurface.reduction`).
    fixed : int array, optional
        Vector dofs that do not move.
    n_fixed_rows : int
        Further coefficients after the surface's own that never move (an inflow patch).
    ties : (slaves, masters), optional
        Vector dofs that move as others do (see `symmetry`).

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


def rim(surface: object, ring: int, kind: str) -> np.ndarray:
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


def symmetry(
    surface: object, direction: str, end: int, axis: int
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Symmetry plane ``x_axis = const`` through an edge: fixed dofs and ties for `extraction`.

    The trace stays in the plane and the tangent across it stays normal to the plane: component
    ``axis`` of the first ring is fixed, the others are those of the second ring.
    """
    pick = surface.ring if direction == "s" else surface.column
    trace, next_ring = (pick(k if end == 0 else -1 - k) for k in (0, 1))
    along = [c for c in range(3) if c != axis]
    return vector_dofs(trace, (axis,)), (vector_dofs(next_ring, along), vector_dofs(trace, along))
