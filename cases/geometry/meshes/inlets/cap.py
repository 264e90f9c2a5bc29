"""A hole closed by triangles of the size of its rim's edges: the inlet that most files leave out.

Plane of the loop by least squares, a triangular lattice inside, Delaunay; out of the plane the
points stand where weights of the graph put them between those of the rim.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve
from scipy.spatial import Delaunay, QhullError, cKDTree

from ..facet_mesh import FacetMesh, MeshError, place
from ..figures import Hole
from ..flat_triangles import plane_areas, plane_cross, sides_of
from .loops import rims, told
from .selection import HOLE, numbers_of

CLEAR = 0.65  # rim edges that inner points keep from the rim
THIN = 1e-9  # area over the square of a rim edge that is none
CAP = "cap of the hole"


def capped(facets: FacetMesh, inlet: Any) -> tuple[FacetMesh, np.ndarray]:
    """Close one hole.

    Parameters
    ----------
    facets : FacetMesh
        Oriented, open.
    inlet : "hole" or {"hole": [x, y, z]}
        The only hole, or the one nearest to a point.

    Returns
    -------
    FacetMesh, (k,) int array
        With the new triangles at its end, and those; they are the group "cap of the hole" too.

    Raises
    ------
    MeshError
        No hole, several without a point to choose by, or one that no plane fill closes.
    """
    hole = _chosen(facets.points, rims(facets.points, facets.triangles), inlet)
    loop = hole.loop
    inner, fill = _fill(facets.points[loop])
    n, m = len(facets.points), len(facets.triangles)
    number = np.concatenate([loop, n + np.arange(len(inner))])
    added = number[fill]
    new = np.arange(m, m + len(added))
    points = np.concatenate([facets.points, inner])
    triangles = np.concatenate([facets.triangles, added])
    note = f"inlet: a hole ({told([hole])}) was capped by {len(added)} triangles"
    return FacetMesh(
        points,
        triangles,
        {**facets.groups, CAP: new},
        _middles(facets, points, triangles),
        _reference(facets, loop, inner),
        (*facets.notes, note),
    ), new


def _chosen(points: np.ndarray, loops: list[Hole], inlet: Any) -> Hole:
    if not loops:
        raise MeshError(
            'geometry.inlet = "hole": the mesh is closed; choose the inlet\'s triangles by a '
            "group, sphere, box or plane"
        )
    if isinstance(inlet, str):
        if len(loops) > 1:
            raise MeshError(
                f'geometry.inlet = "hole": the mesh has {len(loops)} holes ({told(loops)}); name '
                "one by a point near it, { hole = [x, y, z] }, and close the others in the file"
            )
        return loops[0]
    at = numbers_of(inlet[HOLE], (3,), f"geometry.inlet.{HOLE}")
    return min(loops, key=lambda hole: np.linalg.norm(points[hole.loop] - at, axis=1).min())


def _fill(rim: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inner points ``(k, 3)`` and triangles of rim and inner points, against the rim's sense."""
    centre = rim.mean(axis=0)
    axes = np.linalg.svd(rim - centre, full_matrices=False)[2]
    if _signed_area((rim - centre) @ axes[:2].T) > 0.0:  # the cap runs the rim backwards
        axes[1] *= -1.0
    plane = (rim - centre) @ axes[:2].T
    spacing = float(np.linalg.norm(np.roll(plane, -1, axis=0) - plane, axis=1).mean())
    at = np.concatenate([plane, _inside(plane, spacing)])
    try:
        triangles = Delaunay(at).simplices
    except QhullError as wrong:
        raise _unfillable(rim, "its points lie on a line") from wrong
    area = plane_areas(at, triangles)
    triangles[area < 0.0] = triangles[area < 0.0][:, ::-1]
    # rim vertices on a line make triangles without area
    kept = within(plane, at[triangles].mean(axis=1)) & (np.abs(area) > THIN * spacing**2)
    triangles = triangles[kept]
    if np.unique(triangles).size < len(at) or not _rim_kept(triangles, len(rim)):
        raise _unfillable(rim, "its polygon crosses itself or is too ragged for a plane fill")
    height = _lifted((rim - centre) @ axes[2], len(at), triangles)
    inner = np.column_stack([at[len(rim) :], height])
    return centre + inner @ axes, triangles


def _unfillable(rim: np.ndarray, why: str) -> MeshError:
    return MeshError(
        f"the hole of {len(rim)} edges at {place(rim.mean(axis=0))} cannot be capped, {why}: "
        "close it in a mesh tool and choose the inlet by a sphere or a group"
    )


def _signed_area(polygon: np.ndarray) -> float:
    return float(0.5 * plane_cross(polygon, np.roll(polygon, -1, axis=0)).sum())


def _inside(polygon: np.ndarray, spacing: float) -> np.ndarray:
    """Lattice points clear of a polygon's edges, or the one that is farthest from them."""
    grid, depth = _lattice_inside(polygon, spacing)
    if np.any(depth > CLEAR * spacing):
        return grid[depth > CLEAR * spacing]
    grid, depth = _lattice_inside(polygon, 0.25 * spacing)
    return grid[[np.argmax(depth)]] if len(grid) else grid


def _lattice_inside(polygon: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """A triangular lattice inside a polygon and its points' distances from the edges."""
    reach = np.abs(polygon).max() + spacing
    n = int(np.ceil(2.0 * reach / spacing))
    i, j = (g.ravel() for g in np.meshgrid(range(-n, n + 1), range(-n, n + 1)))
    grid = spacing * np.column_stack([i + 0.5 * j, np.sqrt(0.75) * j])
    grid = grid[within(polygon, grid)]
    t = np.linspace(0.0, 1.0, 8, endpoint=False)[:, None, None]
    edges = polygon + t * (np.roll(polygon, -1, axis=0) - polygon)
    return grid, cKDTree(edges.reshape(-1, 2)).query(grid)[0] if len(grid) else np.empty(0)


def within(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points ``(n, 2)`` lie inside a polygon ``(m, 2)``, by crossings of a ray."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    height = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / height
    return np.sum(spans & (x < crossing), axis=1) % 2 == 1


def _rim_kept(triangles: np.ndarray, n: int) -> bool:
    """Whether the fill's own rim is the loop, backwards."""
    if not len(triangles):
        return False
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    have = {tuple(s) for s in sides.tolist()}
    rim = {(a, b) for a, b in have if (b, a) not in have}
    return rim == {((k + 1) % n, k) for k in range(n)}


def _lifted(rim: np.ndarray, count: int, triangles: np.ndarray) -> np.ndarray:
    """Heights of inner points ``(k,)``, each the mean of its neighbours', from the rim's."""
    i = triangles[:, [0, 1, 2, 1, 2, 0]].ravel()
    j = triangles[:, [1, 2, 0, 0, 1, 2]].ravel()
    joined = coo_matrix((np.ones(i.size), (i, j)), shape=(count, count)).tocsr()
    joined.data[:] = 1.0
    laplacian = (diags(np.asarray(joined.sum(axis=1)).ravel()) - joined).tocsc()
    n = len(rim)
    return np.atleast_1d(spsolve(laplacian[n:, n:], -laplacian[n:, :n] @ rim))


def _middles(facets: FacetMesh, points: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """Middles of all sides: straight within the cap, its neighbours' along the rim."""
    if facets.middles is None:
        return None
    m = len(facets.triangles)
    side = sides_of(triangles)
    middles = points[side].mean(axis=2)
    middles[:m] = facets.middles
    known = dict(zip(map(tuple, side[:m].reshape(-1, 2).tolist()), facets.middles.reshape(-1, 3),
                     strict=True))  # fmt: skip
    for t, k in np.ndindex(len(triangles) - m, 3):
        a, b = side[m + t, k]
        middles[m + t, k] = known.get((b, a), middles[m + t, k])
    return middles


def _reference(facets: FacetMesh, loop: np.ndarray, inner: np.ndarray) -> np.ndarray | None:
    """Unfolded places of the new points, by the affine map that fits the rim's best."""
    if facets.reference is None:
        return None
    rim, unfolded = facets.points[loop], facets.reference[loop]
    centre, to = rim.mean(axis=0), unfolded.mean(axis=0)
    affine = np.linalg.lstsq(rim - centre, unfolded - to, rcond=None)[0]
    return np.concatenate([facets.reference, (inner - centre) @ affine + to])
