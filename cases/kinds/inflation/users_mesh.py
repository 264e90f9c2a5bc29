"""A bag from a user's mesh file, step by step as its `[geometry]` says."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...geometry.bag import Bag
from ...geometry.folding import Map
from ...geometry.meshes.facet_mesh import FacetMesh, MeshError
from ...sections import Physical, SceneError
from .mesh_config import UNITS, MeshGeometry, Region, TriangleMesh


@lru_cache(maxsize=2)  # counting its elements takes the whole way
def bag_of(g: MeshGeometry, m: TriangleMesh, physical: Physical | None) -> Bag:
    """The bag of a scene's mesh.

    Raises
    ------
    SceneError
        A mesh that cannot be used: what, where and the remedy.
    """
    try:
        return _bag(g, m, 1.0 if physical is None else physical.length)
    except MeshError as error:
        raise SceneError([str(error)]) from error


def facets_of(g: MeshGeometry, length: float) -> FacetMesh:
    """The repaired facets of a scene's mesh, in units of L = ``length`` metres."""
    from ...geometry.meshes.opening import opened
    from ...geometry.meshes.repair import repaired

    facets = _read(g.file.path, g, length)
    if g.reference:
        facets = _with_reference(facets, _read(g.reference.path, g, length), g.reference.name)
    facets = repaired(facets, weld=g.weld, component=g.component)
    return opened(facets, g.opening) if g.opening else facets


def _read(path: Path, g: MeshGeometry, length: float) -> FacetMesh:
    from ...geometry.meshes.reading import read_facets

    facets = read_facets(path)
    scale = UNITS[g.unit] / length if g.unit else 1.0
    return facets if scale == 1.0 else _scaled(facets, scale)


def _scaled(facets: FacetMesh, scale: float) -> FacetMesh:
    def times(points: np.ndarray | None) -> np.ndarray | None:
        return None if points is None else scale * points

    return replace(
        facets,
        points=scale * facets.points,
        middles=times(facets.middles),
        reference=times(facets.reference),
    )


def _with_reference(facets: FacetMesh, unfolded: FacetMesh, name: str) -> FacetMesh:
    """Facets that know their unfolded places."""
    same = facets.points.shape == unfolded.points.shape
    if not same or not np.array_equal(facets.triangles, unfolded.triangles):
        raise MeshError(
            f"geometry.reference: {name} has {len(unfolded.triangles)} triangles on "
            f"{len(unfolded.points)} points, geometry.file {len(facets.triangles)} on "
            f"{len(facets.points)}, or numbers them otherwise; save both from one mesh"
        )
    return replace(facets, reference=unfolded.points)


def _bag(g: MeshGeometry, m: TriangleMesh, length: float) -> Bag:
    from ...geometry.meshes.mesh_bag import mesh_bag

    facets = facets_of(g, length)
    count = len(facets.triangles) * 4**m.split
    if count > m.most:
        raise MeshError(
            f"mesh.most: {count} triangles are more than {m.most}; decimate the file in a mesh "
            "tool, lower mesh.split, or raise mesh.most"
        )
    folding = fold = None
    if g.folds:
        from ...geometry.meshes.pattern import pattern_folding

        folding = pattern_folding(g.folds, g.along, facets.points)
        placed, fold = folding.maps
        facets = moved(facets, placed)
    bag = mesh_bag(
        facets,
        inlet=_place(g.inlet),
        degree=m.degree,
        density=m.density,
        smooth=g.smooth,
        crease=g.crease,
        split=m.split,
        rest=g.rest or None,
        fold=fold,
    )
    return replace(bag, folding=folding)


def moved(facets: FacetMesh, rigidly: Map) -> FacetMesh:
    """Facets in another place."""

    def at(points: np.ndarray | None) -> np.ndarray | None:
        return None if points is None else rigidly(points.reshape(-1, 3)).reshape(points.shape)

    return replace(facets, points=rigidly(facets.points), middles=at(facets.middles))


def _place(inlet: str | Region) -> object:
    """An inlet as the way to a bag takes it: a name, or a kind of region and its numbers."""
    if isinstance(inlet, str):
        return inlet
    return {name: list(v) for name, v in vars(inlet).items() if v}
