"""What a user should know of a mesh before it runs: slivers, thin and sharp places, one line each.

Thinness is ``eps = (2 V / A) / (2 sqrt(A / 2 pi))``, distance of the sheets over their extent: in
thin films an error of the fluid's operators is up to ``0.1 eps^-2.6`` times larger in the traction.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .facet_mesh import FacetMesh, MeshError, place
from .figures import SLIVER, mesh_quality
from .flat_triangles import angles_between, facet_normals, smallest_angles
from .mending.topology import edges_of
from .narrowest import facing_distances
from .smoothing.curved_mesh import CurvedMesh, enclosed_volume, triangle_areas

MEASURED = 0.01  # thinness down to which the fluid was measured, on disc bags of 18 x 8 elements
FLAT = 1e-5  # distance of the sheets over the extent below which they coincide
PINCHED = 0.5  # of the mean distance of the sheets
TURNED_BACK = 120.0  # degrees; sharper edges are seams
MOST_PLACES = 200  # to be drawn


@dataclass(frozen=True)
class MeshFinding:
    """One line on a mesh.

    Attributes
    ----------
    text : str
    warns : bool
        Whether something should be done about it.
    places : (k, 3) array
        Where, to be marked in a picture; empty if everywhere.
    """

    text: str
    warns: bool = False
    places: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))


def findings(mesh: CurvedMesh | FacetMesh) -> list[MeshFinding]:
    """What can be said of a mesh that is welded and oriented outwards.

    Parameters
    ----------
    mesh : CurvedMesh or FacetMesh
        Facets are looked at as they are, so that bags without thickness can be.

    Returns
    -------
    list of MeshFinding
        Figures first; those that warn name the remedy.
    """
    if isinstance(mesh, FacetMesh):
        facets, control, degree = mesh, mesh.points[mesh.triangles], 1
    else:
        facets, control, degree = mesh.facets, mesh.control, mesh.degree
    found = _triangles(facets)
    seams, turn = _seams(facets)
    if len(seams):
        found.append(
            MeshFinding(
                f"{len(seams)} edges turn back by more than {TURNED_BACK:g} degrees (the sharpest "
                f"by {turn:.4g}): a seam, where the gap between the sheets closes"
            )
        )
    if not facets.triangles.size or np.any(edges_of(facets.triangles).counts == 1):
        return found
    return [*found, *_sheets(control, degree, beside_seams(facets))]


def beside_seams(facets: FacetMesh) -> np.ndarray:
    """Triangles ``(m,) bool`` with a vertex on a seam."""
    return np.asarray(np.isin(facets.triangles, _seams(facets)[0]).any(axis=1))


def refuse_coincident(facets: FacetMesh) -> None:
    """Refuse a closed mesh without room between its sheets.

    Raises
    ------
    MeshError
        With the remedy.
    """
    if np.any(edges_of(facets.triangles).counts == 1):
        return
    control = facets.points[facets.triangles]
    if told := _coincident(*_volume_and_area(control, 1)):
        raise MeshError(told)


def _volume_and_area(control: np.ndarray, degree: int) -> tuple[float, float]:
    return abs(enclosed_volume(control, degree)), float(triangle_areas(control, degree).sum())


def _coincident(volume: float, area: float) -> str:
    """What to do about sheets without room between them; empty where there is some."""
    extent = float(np.sqrt(area / (2.0 * np.pi)))
    if 2.0 * volume > FLAT * extent * area:
        return ""
    return (
        f"sheets coincide: volume {volume:.2g} in an area of {area:.3g}; set geometry.opening "
        f"to half the distance that they get, about {2.0 * MEASURED * extent:.2g}"
    )


def _triangles(facets: FacetMesh) -> list[MeshFinding]:
    """Angles and edges."""
    found = mesh_quality(facets.points, facets.triangles)
    line = (
        f"smallest angle {found.smallest_angle:.3g} degrees at {place(found.sharpest)}; edges "
        f"{found.shortest:.3g} to {found.longest:.3g}, median {found.median:.3g}"
    )
    corners = facets.points[facets.triangles]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    slivers = smallest_angles(facets.points, facets.triangles) < SLIVER
    short = sides.min(axis=1) < 1e-3 * found.median
    places = corners[slivers | short].mean(axis=1)[:MOST_PLACES]
    return [MeshFinding(line), *(MeshFinding(w, True, places) for w in found.warnings())]


def _seams(facets: FacetMesh) -> tuple[np.ndarray, float]:
    """Edges ``(k, 2)`` at which the surface turns back, and the largest turn in degrees."""
    edges = edges_of(facets.triangles)
    sides, others = edges.pairs()
    normals = facet_normals(facets.points, facets.triangles)
    turn = np.degrees(angles_between(normals[sides // 3], normals[others // 3]))
    back = edges.of.ravel()[sides[turn > TURNED_BACK]]
    return edges.ends[back], float(turn.max(initial=0.0))


def _sheets(control: np.ndarray, degree: int, beside: np.ndarray) -> list[MeshFinding]:
    """Distance of the sheets of a closed mesh, and what it means for the fluid.

    Triangles ``beside (m,)`` a seam are thin by nature and not counted.
    """
    volume, area = _volume_and_area(control, degree)
    if told := _coincident(volume, area):
        return [MeshFinding(told, True)]
    gap, extent = 2.0 * volume / area, np.sqrt(area / (2.0 * np.pi))
    thinness = 0.5 * gap / extent
    places, across = facing_distances(control, degree, gap)
    each = across.size // control.shape[0]
    weights = np.repeat(triangle_areas(control, degree), each) / (each * area)
    across[np.repeat(beside, each)] = np.inf
    thin = across < PINCHED * gap
    line = f"mean distance of the sheets 2 V / A = {gap:.3g}, {thinness:.2g} of the extent"
    if np.isfinite(across).any():
        k = int(across.argmin())
        where = ", away from seams," if beside.any() else ""
        line += f"; narrowest{where} {across[k]:.3g} at {place(places[k])}"
    if thin.any():
        line += f"; {100.0 * weights @ thin:.2g} % of the area faces a sheet within half of it"
    found = [MeshFinding(line, False, places[thin][:MOST_PLACES])]
    if thinness < MEASURED:
        found.append(
            MeshFinding(
                f"thinness {thinness:.2g}: an error of the fluid's operators may be "
                f"{0.1 * thinness**-2.6:.1g} times larger in the traction, and below "
                f"{MEASURED:g} fluid.tolerance was never measured; open the sheets to "
                f"{4.0 * MEASURED * extent:.2g} apart, or expect a slow and inexact start",
                True,
            )
        )
    return found
