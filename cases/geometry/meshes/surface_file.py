"""A mesh file as a surface for library use: bodies in a flow, open shells, bags with an inlet.

body = read_surface("body.stl")
force = StokesFlow(body.patches()).traction(np.array([0.0, 0.0, 1.0])).force()
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shells.surfaces.triangles.triangle_surface import TriangleSurface

from ..folding import Folding
from .facet_mesh import FacetMesh, MeshError
from .inlets.checks import check_closed
from .inlets.cut import kept_groups, with_inlet
from .loading import loaded, mesh_warnings
from .mesh_bag import MeshBag, assembled, part, shaped
from .pattern import pattern_folding
from .reading import of_file
from .smoothing.curved_mesh import CurvedMesh

if TYPE_CHECKING:
    from hbem.surfaces.patches import BezierPatches
    from shells.surfaces.triangles.triangle_basis import TriangleBasis


@dataclass(frozen=True)
class MeshSurface:
    """Bezier triangles from a mesh file, with an inlet or without, closed or open.

    Attributes
    ----------
    mesh : CurvedMesh
        All triangles, with the file's groups.
    inlet : (k,) int array
        Triangles of the inlet; empty without one.
    density : int
        Degree of the traction's functions.
    folding : Folding, optional
        How a pattern was folded.
    file : str
        Name of the file, with which errors begin.
    """

    mesh: CurvedMesh
    inlet: np.ndarray
    density: int
    folding: Folding | None = None
    file: str = ""

    @cached_property
    def _part(self) -> tuple[TriangleSurface, np.ndarray]:
        own = np.setdiff1d(np.arange(len(self.mesh.control)), self.inlet)
        return part(self.mesh, own, self.density)[0], own

    @property
    def surface(self) -> TriangleSurface:
        """The triangles, but for an inlet's."""
        return self._part[0]

    @cached_property
    def coefficients(self) -> np.ndarray:
        """Of `surface`, ``(n_coefficients, 3)``."""
        surface, own = self._part
        return surface.coefficients_of(self.mesh.control[own])

    @cached_property
    def flat(self) -> np.ndarray | None:
        """The same in the unfolded reference, if there is one."""
        surface, own = self._part
        return None if self.mesh.flat is None else surface.coefficients_of(self.mesh.flat[own])

    @property
    def notes(self) -> tuple[str, ...]:
        """What was read, repaired, left out and smoothed, one line each."""
        return self.mesh.facets.notes

    @property
    def warnings(self) -> tuple[str, ...]:
        """What may hurt, with the remedy."""
        return mesh_warnings(self.mesh.facets)

    def patches(self) -> BezierPatches:
        """Geometry and density of a closed surface for the boundary integrals, inlet included.

        Returns
        -------
        BezierPatches
            With its configuration; of a bag, membrane and inlet.
        """
        from hbem.surfaces.patches import union

        if self.inlet.size:
            bag = self.bag()
            assert bag.inlet is not None  # it was just asked
            return replace(union(bag.membrane, bag.inlet), coefficients=bag.coefficients)
        return replace(union(self.surface), coefficients=self.coefficients)

    def basis(self) -> TriangleBasis:
        """Functions on `surface` for a shell, stress-free where it is unfolded, if it is.

        Returns
        -------
        TriangleBasis
        """
        from shells.surfaces.triangles.triangle_basis import TriangleBasis

        return TriangleBasis(self.surface, self.coefficients if self.flat is None else self.flat)

    def bag(self) -> MeshBag:
        """Membrane and inlet, or a closed membrane alone.

        Returns
        -------
        MeshBag

        Raises
        ------
        MeshError
            An open surface, or several.
        """
        with of_file(self.file):
            check_closed(self.mesh.facets)
            return replace(assembled(self.mesh, self.inlet, self.density), folding=self.folding)


def read_surface(
    path: str | os.PathLike[str],
    *,
    inlet: Any = None,
    unit: str = "",
    length: float = 1.0,
    rest: str | Sequence[str] | None = None,
    degree: int = 3,
    density: int = 1,
    smooth: bool = True,
    crease: float = 30.0,
    surface: Callable[[np.ndarray], np.ndarray] | None = None,
    split: int = 0,
    reference: str | os.PathLike[str] | None = None,
    opening: float = 0.0,
    folds: Sequence[Any] = (),
    along: Sequence[float] = (1.0, 0.0, 0.0),
    weld: float = 1e-5,
    component: str = "all",
    most: int = 20_000,
) -> MeshSurface:
    """Read, repair, smooth and cut a mesh.

    Parameters
    ----------
    path : path
        STL, OBJ, PLY, OFF, Gmsh, VTK, VTU, Abaqus, Nastran or LS-DYNA.
    inlet, rest :
        See `mesh_bag`; regions in units of L. Without an inlet the surface may be open.
    unit, length, reference, opening, weld, component :
        See `loaded`.
    degree, density, smooth, crease, surface, split :
        See `mesh_bag`.
    folds, along :
        See `pattern_folding`; in units of L.
    most : int
        Triangles above which a mesh is refused.

    Returns
    -------
    MeshSurface

    Raises
    ------
    MeshError
        What cannot be used: file or key (as scenes name it), what, where, and the remedy, in one
        line.
    """
    facets = loaded(
        path,
        unit=unit,
        length=length,
        reference=reference,
        weld=weld,
        component=component,
        opening=opening,
        kept=None if rest is None else partial(kept_groups, inlet=inlet, rest=rest),
    )
    with of_file(path):
        check_count(facets, split, most)
        chosen = np.empty(0, dtype=int)
        if inlet is not None:
            facets, chosen = with_inlet(facets, inlet, left_out=rest is not None)
        folding = pattern_folding(folds, along, facets.points) if len(folds) else None
        mesh, chosen = shaped(
            facets,
            chosen,
            degree=degree,
            smooth=smooth,
            crease=crease,
            surface=surface,
            split=split,
            fold=folding,
        )
    return MeshSurface(mesh, chosen, density, folding, Path(path).name)


def check_count(facets: FacetMesh, split: int, most: int) -> None:
    """Refuse more triangles than ``most`` before they are made.

    Raises
    ------
    MeshError
    """
    count = len(facets.triangles) * 4**split
    if count > most:
        raise MeshError(
            f"mesh.most: {count} triangles are more than {most}; decimate the file in a mesh tool, "
            "lower mesh.split, or raise mesh.most"
        )
