"""What an inlet must be: one patch with one rim, two elements across, and a bag closed by it."""

from __future__ import annotations

import numpy as np

from ..facet_mesh import FacetMesh, MeshError, place
from ..mending.topology import sheets
from .loops import rims, told


def check_closed(facets: FacetMesh, *, capped: bool = False, left_out: bool = False) -> None:
    """One closed surface, that a bag is to be made of.

    ``capped`` says that one hole was closed already, ``left_out`` that groups were left out: the
    remedies differ.

    Raises
    ------
    MeshError
        Holes, with length and centre of each, or several components, with the size of each.
    """
    loops = rims(facets.points, facets.triangles)
    if loops:
        other = "other " if capped else ""
        remedy = "close them in the file" if capped else 'take one as geometry.inlet = "hole"'
        remedy += ", or add the groups that lie there to geometry.rest" if left_out else ""
        one = "another hole" if capped else "a hole"
        what = one if len(loops) == 1 else f"{len(loops)} {other}holes"
        raise MeshError(
            f"the mesh has {what} ({told(loops)}): {remedy}; only a structure without flow may be "
            "open"
        )
    parts = pieces(facets.triangles)
    if len(parts) > 1:
        sizes = ", ".join(_described(facets, part) for part in parts[:4])
        raise MeshError(
            f"a bag is one closed surface, the mesh has {len(parts)} ({sizes}): name the groups "
            'to use in geometry.rest, or keep the largest, geometry.component = "largest"'
        )


def check_patch(facets: FacetMesh, chosen: np.ndarray) -> None:
    """One connected patch with one rim, and a membrane left over, connected too.

    Raises
    ------
    MeshError
        What is not so, where, and the remedy.
    """
    rest = np.setdiff1d(np.arange(len(facets.triangles)), chosen)
    if not rest.size:
        raise MeshError(
            "geometry.inlet: all triangles of the mesh are chosen and no membrane is left; choose "
            "fewer"
        )
    parts = pieces(facets.triangles[chosen])
    if len(parts) > 1:
        found = ", ".join(_described(facets, chosen[part]) for part in parts[:4])
        raise MeshError(
            f"geometry.inlet: the chosen triangles are {len(parts)} separate patches ({found}): "
            "choose one"
        )
    loops = rims(facets.points, facets.triangles[chosen])
    if len(loops) != 1:
        raise MeshError(
            f"geometry.inlet: the patch has {len(loops)} rims ({told(loops)}), must have one: it "
            "surrounds other triangles; add them to it or choose a smaller one"
        )
    left = pieces(facets.triangles[rest])
    if len(left) > 1:
        found = ", ".join(_described(facets, rest[part]) for part in left[:4])
        raise MeshError(
            f"geometry.inlet: the patch cuts the membrane into {len(left)} parts ({found}): choose "
            "a patch inside one of them"
        )


def check_across(facets: FacetMesh, chosen: np.ndarray) -> None:
    """At least two elements across: some vertex that is not on the rim.

    Raises
    ------
    MeshError
        All vertices are on the rim.
    """
    patch = facets.triangles[chosen]
    on_rim = rims(facets.points, patch)[0].loop
    if on_rim.size == np.unique(patch).size:
        raise MeshError(
            f"geometry.inlet: the patch of {chosen.size} triangle(s) at "
            f"{place(facets.points[on_rim].mean(axis=0))} is one element across, all its vertices "
            "are on the rim: raise mesh.split, or choose more triangles"
        )


def pieces(triangles: np.ndarray) -> list[np.ndarray]:
    """Triangles of each part that edges connect, largest first."""
    count, label = sheets(triangles)
    parts = [np.flatnonzero(label == k) for k in range(count)]
    return sorted(parts, key=lambda part: -part.size)


def _described(facets: FacetMesh, part: np.ndarray) -> str:
    centre = facets.points[facets.triangles[part]].mean(axis=(0, 1))
    return f"{part.size} triangle(s) at {place(centre)}"
