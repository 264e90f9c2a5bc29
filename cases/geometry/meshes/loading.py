"""From a mesh file to repaired facets in units of L: read, scaled, unfolded, mended, opened."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from .facet_mesh import FacetMesh, MeshError
from .figures import mesh_quality
from .findings import refuse_coincident
from .opening import opened
from .placing import UNITS, scaled
from .reading import of_file, read_facets
from .repair import repaired

LARGE, SMALL = 100.0, 0.01  # sizes in units of L beyond which a unit is likely to be missing


def loaded(
    path: str | os.PathLike[str],
    *,
    unit: str = "",
    length: float = 1.0,
    reference: str | os.PathLike[str] | None = None,
    weld: float = 1e-5,
    component: str = "all",
    opening: float = 0.0,
    kept: Callable[[FacetMesh], FacetMesh] | None = None,
) -> FacetMesh:
    """Facets of a mesh file, repaired.

    Parameters
    ----------
    path : path
    unit : str
        Of the file's lengths, of `UNITS`; without it they are in units of L.
    length : float
        L in metres, where a unit is given.
    reference : path, optional
        A file with the same triangles, unfolded.
    weld, component :
        See `repaired`.
    opening : float
        Half the distance given to coincident sheets, in units of L.
    kept : callable, optional
        What is kept of the file's triangles, in units of L; inner walls left out need no repair.

    Returns
    -------
    FacetMesh
        Lengths in units of L.

    Raises
    ------
    MeshError
        An unknown unit, a reference of other triangles, or what reading, repair and opening refuse:
        begins with the file's name, or with the key that is wrong, as scenes name it.
    """
    factor = _factor(unit, length)
    facets = scaled(read_facets(path), factor)
    if reference is not None:
        unfolded = scaled(read_facets(reference), factor)
        facets = _unfolding(facets, unfolded, Path(reference).name)
    with of_file(path):
        facets = facets if kept is None else kept(facets)
        facets = repaired(facets, weld=weld, component=component)
        facets = replace(facets, notes=(*facets.notes, _extents(facets, unit, length)))
        if opening:
            return opened(facets, opening)
        refuse_coincident(facets)
    return facets


def _factor(unit: str, length: float) -> float:
    if not unit:
        return 1.0
    if unit not in UNITS:
        raise MeshError(f"geometry.unit = {unit!r}: expected one of {', '.join(UNITS)}")
    if not (np.isfinite(length) and length > 0.0):
        raise MeshError(f"physical.length = {length!r}: expected a positive number of metres")
    return UNITS[unit] / length


def _unfolding(facets: FacetMesh, unfolded: FacetMesh, name: str) -> FacetMesh:
    """Facets that know their unfolded places."""
    same = facets.points.shape == unfolded.points.shape
    if not same or not np.array_equal(facets.triangles, unfolded.triangles):
        raise MeshError(
            f"geometry.reference: {name} has {len(unfolded.triangles)} triangles on "
            f"{len(unfolded.points)} points, geometry.file {len(facets.triangles)} on "
            f"{len(facets.points)}, or numbers them otherwise; save both from one mesh"
        )
    return replace(facets, reference=unfolded.points)


def _extents(facets: FacetMesh, unit: str, length: float) -> str:
    size = " x ".join(f"{x:.4g}" for x in np.ptp(facets.points, axis=0))
    return f"extends over {size} L" + (f", L = {length / UNITS[unit]:.4g} {unit}" if unit else "")


def mesh_warnings(facets: FacetMesh) -> tuple[str, ...]:
    """What hurts in a mesh in units of L: slivers, tiny edges, a size that looks like millimetres.

    Parameters
    ----------
    facets : FacetMesh

    Returns
    -------
    tuple of str
    """
    found = mesh_quality(facets.points, facets.triangles).warnings()
    size = float(np.ptp(facets.points, axis=0).max())
    if not SMALL <= size <= LARGE:
        found.append(
            f"the mesh is {size:.3g} L large: is geometry.unit missing, or physical.length another?"
        )
    return tuple(found)
