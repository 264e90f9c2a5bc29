"""A bag from a user's mesh file, as its `[geometry]` and `[mesh]` say."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from ...geometry.meshes.facet_mesh import MeshError
from ...sections import Physical, SceneError
from .mesh_config import MeshGeometry, Region, TriangleMesh

if TYPE_CHECKING:
    from ...geometry.meshes.mesh_bag import MeshBag


@lru_cache(maxsize=2)  # counting its elements takes the whole way
def bag_of(g: MeshGeometry, m: TriangleMesh, physical: Physical | None) -> MeshBag:
    """The bag of a scene's mesh.

    Raises
    ------
    SceneError
        A mesh that cannot be used: what, where and the remedy.
    """
    from ...geometry.meshes.surface_file import read_surface

    try:
        return read_surface(
            g.file.path,
            unit=g.unit,
            length=1.0 if physical is None else physical.length,
            reference=g.reference.path if g.reference else None,
            weld=g.weld,
            component=g.component,
            opening=g.opening,
            inlet=_place(g.inlet),
            rest=g.rest or None,
            smooth=g.smooth,
            crease=g.crease,
            folds=g.folds,
            along=g.along,
            degree=m.degree,
            density=m.density,
            split=m.split,
            most=m.most,
        ).bag()
    except MeshError as error:
        raise SceneError([str(error)]) from error


def _place(inlet: str | Region) -> object:
    """An inlet as the way to a bag takes it: a name, or a kind of region and its numbers."""
    if isinstance(inlet, str):
        return inlet
    return {name: list(v) for name, v in vars(inlet).items() if v}
