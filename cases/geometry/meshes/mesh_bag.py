"""From an oriented mesh to a bag: the inlet cut out, membrane and patch with one curve between.

Smoothing comes before the cut, so that both sides of the rim have the same edges. Membrane and
inlet number their own coefficients: the traction jumps across the rim by construction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from shells.conditions.supports import extraction, vector_dofs
from shells.surfaces.local_elements import functions, lattice, middle
from shells.surfaces.triangles.triangle_surface import TriangleSurface

from ..bag import Bag
from ..folding import Folding, Map
from ..rays import first_hits
from .facet_mesh import FacetMesh, MeshError
from .findings import beside_seams, refuse_coincident
from .inlets.checks import check_across
from .inlets.cut import with_inlet
from .inlets.inflow import RimCurve, inflow_profile
from .loading import mesh_warnings
from .narrowest import narrowest_gap
from .placing import moved
from .smoothing.curved_mesh import CurvedMesh, curved_mesh, split_members

PATCH_CELLS = 12  # of each triangle's side, where the deepest point of the patch is sought
RIMS = ("hinged", "clamped")


@dataclass(frozen=True)
class Rim:
    """Edges that membrane and inlet have in common.

    Attributes
    ----------
    membrane, inlet : (k,) int array
        Numbers of the same edges in ``membrane.graph`` and in ``inlet.graph``.
    """

    membrane: np.ndarray
    inlet: np.ndarray


@dataclass(frozen=True, kw_only=True)
class MeshBag(Bag):
    """A bag of Bezier triangles.

    Attributes
    ----------
    mesh : CurvedMesh
        Membrane and inlet as one, with groups.
    patch : (k,) int array
        Its triangles that are the inlet, in the order of the inlet's elements.
    rim : Rim
        Where both meet; without edges if there is no inlet.
    narrowest : float
        Smallest sampled distance of sheets that face each other, away from seams.
    faces : float
        Distance from the inlet outward to the nearest sheet; infinite if there is none.
    warnings : tuple of str
        What may go wrong, with the remedy.
    """

    membrane: TriangleSurface
    inlet: TriangleSurface | None
    mesh: CurvedMesh
    patch: np.ndarray
    rim: Rim
    narrowest: float
    faces: float
    warnings: tuple[str, ...] = ()


def mesh_bag(
    facets: FacetMesh,
    *,
    inlet: Any = None,
    degree: int = 3,
    density: int = 1,
    smooth: bool = True,
    crease: float = 30.0,
    split: int = 0,
    surface: Callable[[np.ndarray], np.ndarray] | None = None,
    fold: Map | Folding | None = None,
    rest: str | Sequence[str] | None = None,
) -> MeshBag:
    """A bag from a mesh that is welded and oriented outwards.

    Parameters
    ----------
    facets : FacetMesh
    inlet : str or mapping, optional
        A group's name, ``"hole"``, or one of ``{"sphere": [x, y, z, r]}``, ``{"box": [[x, y, z],
        [x, y, z]]}``, ``{"plane": [nx, ny, nz, d]}`` and ``{"hole": [x, y, z]}``, in the mesh's
        lengths; None for a closed membrane.
    degree : {2, 3}
        Of the geometry.
    density : {1, 2, 3}
        Of the traction.
    smooth, crease, surface :
        See `control_points`.
    split : int
        How often each triangle of the smooth surface is divided into four.
    fold : callable or Folding, optional
        Map of points ``(n, 3)`` that folds the mesh, which then is the unfolded bag unless it has
        a reference; or the folding of a pattern, whose maps before the last place it rigidly.
    rest : str or sequence of str, optional
        Groups to use for the membrane; the others are named and left out.

    Returns
    -------
    MeshBag

    Raises
    ------
    MeshError
        A mesh that is no bag with this inlet: what, where, and the remedy.
    """
    facets, chosen = with_inlet(facets, inlet, rest)
    mesh, chosen = shaped(
        facets,
        chosen,
        degree=degree,
        smooth=smooth,
        crease=crease,
        split=split,
        surface=surface,
        fold=fold,
    )
    bag = assembled(mesh, chosen, density)
    return replace(bag, folding=fold) if isinstance(fold, Folding) else bag


def shaped(
    facets: FacetMesh,
    chosen: np.ndarray,
    *,
    split: int,
    fold: Map | Folding | None,
    **smoothing: Any,
) -> tuple[CurvedMesh, np.ndarray]:
    """The smooth surface of a mesh, split and folded, and its triangles that come of ``chosen``.

    Raises
    ------
    MeshError
        See `curved_mesh`; an inlet of one element across.
    """
    maps = fold.maps if isinstance(fold, Folding) else (fold,) if fold is not None else ()
    for rigidly in maps[:-1]:  # those of a pattern place it first
        facets = moved(facets, rigidly)
    mesh = curved_mesh(facets, split=split, **smoothing)
    chosen = split_members(chosen, split)
    if chosen.size:
        check_across(mesh.facets, chosen)
    return (folded(mesh, maps[-1]) if maps else mesh), chosen


def folded(mesh: CurvedMesh, fold: Map) -> CurvedMesh:
    """The mesh folded by a map of its points; what it was is its unfolded state, if it has none."""
    xi, eta, _ = lattice("triangle", mesh.degree)
    table = functions("triangle", mesh.degree, xi, eta)
    at = (table @ mesh.control).reshape(-1, 3)
    control = np.linalg.solve(table, np.asarray(fold(at)).reshape(mesh.control.shape))
    points, given = np.asarray(fold(mesh.facets.points)), mesh.facets.reference
    reference = mesh.facets.points if given is None else given
    flat = mesh.control if mesh.flat is None else mesh.flat
    facets = replace(mesh.facets, points=points, reference=reference)
    done = replace(mesh, facets=facets, control=control, flat=flat)
    note = f"folded: volume {mesh.volume:.5g} before, {done.volume:.5g} after"
    return replace(done, facets=replace(facets, notes=(*facets.notes, note)))


def assembled(mesh: CurvedMesh, chosen: np.ndarray, density: int) -> MeshBag:
    """A closed curved mesh as membrane and inlet (its triangles ``chosen``)."""
    refuse_coincident(mesh.facets)
    others = np.setdiff1d(np.arange(len(mesh.control)), chosen)
    membrane, membrane_points = part(mesh, others, density)
    inlet, inlet_points = part(mesh, chosen, density) if chosen.size else (None, None)
    parts = [(membrane, others)] + ([(inlet, chosen)] if inlet is not None else [])

    def numbered(control: np.ndarray) -> np.ndarray:
        return np.concatenate([s.coefficients_of(control[members]) for s, members in parts])

    def support(kind: str) -> csr_matrix:
        if kind not in RIMS:
            raise ValueError(f"a rim is 'hinged' or 'clamped', not {kind!r}")
        fixed = vector_dofs(membrane.rim_coefficients)
        return extraction(membrane.reduction, fixed, 0 if inlet is None else inlet.n_coefficients)

    coefficients = numbered(mesh.control)
    rim, profile, faces = Rim(np.empty(0, int), np.empty(0, int)), None, np.inf
    if inlet is not None and inlet_points is not None:
        rim = _rim(membrane, membrane_points, inlet, inlet_points)
        # equal to the last bit: means of shared control points round differently
        own = membrane.n_coefficients + inlet.on_edges(rim.inlet)
        coefficients[own] = coefficients[membrane.on_edges(rim.membrane)[:, ::-1]]
        profile = _profile(inlet, coefficients[membrane.n_coefficients :], rim)
        faces = _faces(mesh, others, chosen)
    gap = 2.0 * mesh.volume / mesh.area
    narrowest = narrowest_gap(mesh.control, mesh.degree, gap, beside_seams(mesh.facets))
    return MeshBag(
        membrane=membrane,
        inlet=inlet,
        coefficients=coefficients,
        support=support,
        profile=profile,
        gap=gap,
        extent=float(np.sqrt(mesh.area / (2.0 * np.pi))),
        exact_volume=mesh.volume,
        fit_error=mesh.moved,
        flat=None if mesh.flat is None else numbered(mesh.flat),
        notes=mesh.facets.notes,
        mesh=mesh,
        patch=chosen,
        rim=rim,
        narrowest=narrowest,
        faces=faces,
        warnings=(*mesh_warnings(mesh.facets), *_warnings(faces)),
    )


def part(mesh: CurvedMesh, members: np.ndarray, density: int) -> tuple[TriangleSurface, np.ndarray]:
    """Some triangles as a surface of their own, and the mesh's points that are its vertices."""
    used, numbers = np.unique(mesh.facets.triangles[members], return_inverse=True)
    return TriangleSurface(numbers.reshape(-1, 3), mesh.degree, density), used


def _rim(
    membrane: TriangleSurface, above: np.ndarray, inlet: TriangleSurface, below: np.ndarray
) -> Rim:
    """The common edges, by the mesh's points at their ends."""
    mine = np.sort(above[membrane.graph.vertices[membrane.graph.rim]], axis=1)
    theirs = np.sort(below[inlet.graph.vertices[inlet.graph.rim]], axis=1)
    order, other = np.lexsort(mine.T), np.lexsort(theirs.T)
    if not np.array_equal(mine[order], theirs[other]):
        raise MeshError("membrane and inlet do not meet along the whole rim: repair the mesh")
    return Rim(membrane.graph.rim[order], inlet.graph.rim[other])


def _profile(
    inlet: TriangleSurface, coefficients: np.ndarray, rim: Rim
) -> Callable[[np.ndarray], np.ndarray]:
    xi, eta, _ = lattice("triangle", PATCH_CELLS)
    curve = RimCurve(coefficients[inlet.on_edges(rim.inlet)])
    return inflow_profile(curve, inlet.sample(xi, eta) @ coefficients)


def _faces(mesh: CurvedMesh, others: np.ndarray, chosen: np.ndarray) -> float:
    """Distance from the middles of the patch outward to the membrane's triangles."""
    xi, eta, _ = middle("triangle")
    x, s, t = (
        (functions("triangle", mesh.degree, xi, eta, order) @ mesh.control[chosen])[:, 0]
        for order in ((0, 0), (1, 0), (0, 1))
    )
    outward = np.cross(s, t)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    triangles = mesh.facets.points[mesh.facets.triangles[others]]
    return float(first_hits(x, outward, triangles).min())


def _warnings(faces: float) -> tuple[str, ...]:
    if faces == np.inf:
        return ()
    return (
        f"the inlet faces a sheet {faces:.3g} away and would suck it in; choose one that nothing "
        "lies in front of",
    )
