"""The mesh of a bag with its inlet chosen: holes capped, other groups left out, checks passed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..facet_mesh import FacetMesh
from .cap import capped
from .checks import check_closed, check_patch
from .selection import group_triangles, inlet_triangles, is_hole


def with_inlet(
    facets: FacetMesh,
    inlet: Any = None,
    rest: str | Sequence[str] | None = None,
    *,
    left_out: bool = False,
) -> tuple[FacetMesh, np.ndarray]:
    """The mesh of a bag, its hole capped and other groups left out, and its inlet's triangles.

    Parameters
    ----------
    facets : FacetMesh
    inlet, rest :
        See `mesh_bag`.
    left_out : bool
        Whether groups have been left out before, which may have left holes.

    Returns
    -------
    FacetMesh, (k,) int array

    Raises
    ------
    MeshError
        See `mesh_bag`.
    """
    hole = inlet is not None and is_hole(inlet, facets)
    chosen = np.empty(0, dtype=int)
    if inlet is not None and not hole:
        chosen, notes = inlet_triangles(facets, inlet)
        facets = replace(facets, notes=(*facets.notes, *notes))
    if rest is not None:
        facets, chosen = only(facets, rest, chosen)
    if hole:
        facets, chosen = capped(facets, inlet)
    check_closed(facets, capped=hole, left_out=left_out or rest is not None)
    if chosen.size:
        check_patch(facets, chosen)
    return facets, chosen


def kept_groups(facets: FacetMesh, inlet: Any, rest: str | Sequence[str]) -> FacetMesh:
    """Groups of the membrane and the inlet's triangles of a mesh that is not yet repaired.

    Raises
    ------
    MeshError
        An unknown group, or an inlet without triangles.
    """
    chosen = np.empty(0, dtype=int)
    if inlet is not None and not is_hole(inlet, facets):
        chosen, _ = inlet_triangles(facets, inlet)
    return only(facets, rest, chosen)[0]


def restricted(facets: FacetMesh, kept: np.ndarray) -> FacetMesh:
    """A mesh of some triangles, increasing."""
    used, numbers = np.unique(facets.triangles[kept], return_inverse=True)
    groups = {
        name: np.flatnonzero(np.isin(kept, members)) for name, members in facets.groups.items()
    }
    return FacetMesh(
        facets.points[used],
        numbers.reshape(-1, 3),
        {name: members for name, members in groups.items() if members.size},
        None if facets.middles is None else facets.middles[kept],
        None if facets.reference is None else facets.reference[used],
        facets.notes,
    )


def only(
    facets: FacetMesh, rest: str | Sequence[str], chosen: np.ndarray
) -> tuple[FacetMesh, np.ndarray]:
    """Groups of the membrane and the inlet's triangles alone; what is left out is noted."""
    names = [rest] if isinstance(rest, str) else rest
    found = [group_triangles(facets, name, "geometry.rest", "leave the key out") for name in names]
    kept = np.unique(np.concatenate([chosen, *(members for members, _ in found)])).astype(int)
    notes = tuple(note for _, more in found for note in more)
    gone = np.setdiff1d(np.arange(len(facets.triangles)), kept)
    if gone.size:
        groups = [name for name, k in facets.groups.items() if np.isin(k, gone).any()]
        of = f" of {', '.join(map(repr, groups))}" if groups else ""
        notes += (f"left out {gone.size} triangle(s){of}",)
    mesh = restricted(replace(facets, notes=(*facets.notes, *notes)), kept)
    return mesh, np.searchsorted(kept, chosen)
