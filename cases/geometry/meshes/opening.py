"""Room between the coincident sheets of a flat bag, and a second sheet for a single one.

Interior points move off the seam's surface by ``h sqrt(1 - (1 - d / w)^2)``, d the distance to
the seam and w = 2 h: a rim of half ellipses. Then flat sheets are drawn in, until they are hardly
stretched. The flat cut stays the stress-free reference, so that a bag starts as strained as the
opening makes it: the note says by how much.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix

from .facet_mesh import FacetMesh, MeshError, place
from .flat.chords import split_chords
from .flat.drawn import drawn_in
from .flat.plane import fitted_plane
from .flat.sheets import FLAT, Sheets, told_apart, unfolded
from .flat_triangles import area_vectors, plane_areas, sides_of, unit

RIM = 2.0  # width of the opened rim, in h
STRETCHED = 1.5  # beyond, the first steps pull harder than the flow
BLOCK = 2_000_000  # pairs of a point and a seam edge at a time


def opened(facets: FacetMesh, h: float, *, drawn: bool = True) -> FacetMesh:
    """Lift each sheet of a flat bag by ``h`` off the other.

    Parameters
    ----------
    facets : FacetMesh
        Sheets without thickness that share the points of their seam; with a flat reference they
        may be folded, with layers apart. Sheets less than 2 h apart are laid together first.
    h : float
        Half the distance that the sheets are given, in the mesh's unit.
    drawn : bool
        Whether flat sheets give way in their plane, the seam too, as sheets without stretch do;
        without it, or folded, points only move off the plane.

    Returns
    -------
    FacetMesh
        Chords of the seam split, triangles counterclockwise seen from outside, the flat points
        as reference where there was none.

    Raises
    ------
    MeshError
        A single sheet, a mesh that is not flat, or an opening that is not positive or leaves no
        sheet between its rims.
    """
    if not (np.isfinite(h) and h > 0.0):
        raise MeshError(
            f"geometry.opening = {h:g}: half the distance given to two sheets is positive"
        )
    facets = split_chords(_laid_together(facets, h))
    sheets = told_apart(facets)
    if not sheets.seam.size:
        raise MeshError(
            "geometry.opening needs two sheets, and this flat mesh is one with an open rim: "
            "double it (a mirrored copy sewn to its rim), or give both sheets in the file"
        )
    facets = _outward(facets, sheets)
    far = seam_distance(sheets.plan, sheets.plan[sheets.seam])
    far[np.unique(sheets.seam)] = 0.0
    if RIM * h > far.max():
        raise MeshError(
            f"geometry.opening = {h:g}: its rims are {RIM * h:.3g} wide, and no point of the "
            f"sheets is farther than {far.max():.3g} from the seam; use at most "
            f"{far.max() / RIM:.3g}"
        )
    normals = [_normals(facets, side) for side in (sheets.upper, ~sheets.upper)]
    points = facets.points.copy()
    for side, normal in zip((sheets.upper, ~sheets.upper), normals, strict=True):
        own = np.unique(facets.triangles[side])
        points[own] += _height(far[own], h)[:, None] * normal[own]
    middles = facets.middles
    if middles is not None:
        middles = middles + _middle_offsets(facets, sheets, normals, h)
    flat = unfolded(facets)
    plane = fitted_plane(facets.points)
    if drawn and plane.thickness <= FLAT * plane.size:
        moves = drawn_in(points, flat, facets.triangles, plane.axes[:2]) - points
        points = points + moves
        if middles is not None:
            middles = middles + moves[sides_of(facets.triangles)].mean(axis=2)
    lifted = replace(facets, points=points, middles=middles, reference=flat)
    return replace(lifted, notes=(*facets.notes, *_notes(facets, lifted, h)))


def _laid_together(facets: FacetMesh, h: float) -> FacetMesh:
    """Flat points, where sheets lie apart by less than they will."""
    plane = fitted_plane(unfolded(facets))
    if plane.thickness <= FLAT * plane.size:
        return facets
    if facets.reference is not None or facets.middles is not None or plane.thickness > 2.0 * h:
        what = "mesh" if facets.reference is None else "unfolded reference"
        raise MeshError(
            f"geometry.opening = {h:g} is for sheets that lie on each other: the {what} is "
            f"{plane.thickness:.3g} thick over {plane.size:.3g}; drop the opening, or give a flat "
            "reference"
        )
    off = plane.coordinates(facets.points)[:, 2:] * plane.axes[2]
    note = f"sheets up to {plane.thickness:.3g} apart laid into one plane, to be opened evenly"
    return replace(facets, points=facets.points - off, notes=(*facets.notes, note))


def double_sheet(facets: FacetMesh) -> FacetMesh:
    """A flat single sheet and its mirrored copy, sewn at the open edges.

    The copy is the group "mirrored"; groups of the file stay on the first sheet, so that an
    inlet is cut into one of them.

    Raises
    ------
    MeshError
        A mesh that is not flat, has two sheets already or no open edge.
    """
    sheets = told_apart(facets)
    if sheets.seam.size or not sheets.open_edges.size:
        raise MeshError("only a single flat sheet with an open rim can be doubled")
    facets = _outward(facets, replace(sheets, upper=np.ones_like(sheets.upper)))
    n, m = facets.points.shape[0], facets.triangles.shape[0]
    inside = np.setdiff1d(np.arange(n), sheets.open_edges)
    twin = np.arange(n)
    twin[inside] = n + np.arange(inside.size)
    middles, reference = facets.middles, facets.reference
    if middles is not None:
        middles = np.concatenate([middles, middles[:, ::-1]])
    if reference is not None:
        reference = np.concatenate([reference, reference[inside]])
    note = (
        f"one sheet doubled: {m} triangles mirrored and sewn along {len(sheets.open_edges)} edges"
    )
    return replace(
        facets,
        points=np.concatenate([facets.points, facets.points[inside]]),
        triangles=np.concatenate([facets.triangles, twin[facets.triangles][:, [0, 2, 1]]]),
        groups={**facets.groups, "mirrored": np.arange(m, 2 * m)},
        middles=middles,
        reference=reference,
        notes=(*facets.notes, note),
    )


def seam_distance(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Distance of ``points (n, 2)`` from the nearest of the segments ``edges (k, 2, 2)``."""
    a, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    square = np.maximum(np.sum(along**2, axis=1), 1e-300)
    found = []
    for part in np.array_split(points, max(1, points.shape[0] * len(edges) // BLOCK)):
        off = part[:, None] - a
        share = np.clip(np.einsum("nkd,kd->nk", off, along) / square, 0.0, 1.0)
        foot = off - share[:, :, None] * along
        found.append(np.sqrt(np.einsum("nkd,nkd->nk", foot, foot).min(axis=1)))
    return np.concatenate(found)


def _height(far: np.ndarray, h: float) -> np.ndarray:
    return h * np.sqrt(1.0 - np.maximum(1.0 - far / (RIM * h), 0.0) ** 2)


def _outward(facets: FacetMesh, sheets: Sheets) -> FacetMesh:
    """Triangles of the upper sheet counterclockwise in the plane, the others clockwise."""
    turned = (plane_areas(sheets.plan, facets.triangles) > 0.0) != sheets.upper
    if not turned.any():
        return facets
    triangles = facets.triangles.copy()
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    middles = facets.middles
    if middles is not None:
        middles = middles.copy()
        middles[turned] = middles[turned][:, ::-1]
    note = f"{turned.sum()} triangles turned, so that both sheets face outward"
    return replace(facets, triangles=triangles, middles=middles, notes=(*facets.notes, note))


def _normals(facets: FacetMesh, side: np.ndarray) -> np.ndarray:
    """Unit normal of one sheet at each of its points; others get none."""
    triangles = facets.triangles[side]
    rows = np.repeat(np.arange(triangles.shape[0]), 3)
    gather = coo_matrix(
        (np.ones(rows.size), (triangles.ravel(), rows)),
        shape=(facets.points.shape[0], triangles.shape[0]),
    )
    return unit(gather.tocsr() @ area_vectors(facets.points, triangles))


def _middle_offsets(
    facets: FacetMesh,
    sheets: Sheets,
    normals: list[np.ndarray],
    h: float,
) -> np.ndarray:
    """Lift ``(m, 3, 3)`` of the middles: those of straight flat edges, of folded ones alike."""
    assert facets.middles is not None
    ends = sides_of(facets.triangles)
    at = sheets.plan[ends].mean(axis=2)
    if facets.reference is None:
        at = sheets.plane.coordinates(facets.middles.reshape(-1, 3))[:, :2].reshape(at.shape)
    far = seam_distance(at.reshape(-1, 2), sheets.plan[sheets.seam]).reshape(ends.shape[:2])
    kept = {(int(a), int(b)) for a, b in np.sort(sheets.seam, axis=1)}
    for i, k in np.argwhere(np.isin(ends, sheets.seam).all(axis=2)):
        if tuple(sorted(ends[i, k].tolist())) in kept:
            far[i, k] = 0.0  # curved middles of the seam itself
    normal = np.where(
        sheets.upper[:, None, None], normals[0][ends].mean(axis=2), normals[1][ends].mean(axis=2)
    )
    return np.asarray(_height(far, h)[:, :, None] * unit(normal))


def stretches(flat: np.ndarray, now: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Principal stretches ``(m, 2)`` of straight triangles, the smaller first."""
    metrics = []
    for points in (flat, now):
        a, b, c = points[triangles].transpose(1, 0, 2)
        s = np.stack([b - a, c - a], axis=1)
        metrics.append(s @ s.transpose(0, 2, 1))
    squares = np.linalg.eigvals(np.linalg.solve(metrics[0], metrics[1])).real
    return np.sqrt(np.sort(squares, axis=1))


def _notes(before: FacetMesh, after: FacetMesh, h: float) -> list[str]:
    assert after.reference is not None
    found = stretches(after.reference, after.points, after.triangles)
    worst = int(np.abs(found - 1.0).max(axis=1).argmax())
    where = place(after.points[after.triangles[worst]].mean(axis=0))
    cut = "the flat cut" if before.reference is None else "the reference"
    notes = [
        f"sheets opened by {h:.3g} to either side: {cut} is stress-free, and the opening stretches "
        f"it by {found.min():.3g} to {found.max():.3g} (the most at {where}; median of the "
        f"largest {np.median(found[:, 1]):.4g})"
    ]
    if found.max() > STRETCHED:
        notes.append(
            f"warning: the opening stretches triangles at {where} to {found.max():.3g} of their "
            "length: lower geometry.opening, or make them larger beside the seam"
        )
    return notes
