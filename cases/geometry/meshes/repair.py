"""A file's triangles made a surface: welded, without doubles, whole at edges, outwards.

What each step changed is one note; what cannot be mended is refused with its place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .facet_mesh import FacetMesh, MeshError, place
from .figures import sheet_table
from .mending.joining import weld as join
from .mending.needles import turn_needles
from .mending.orientation import part_volumes, turns
from .mending.state import Mending, memberships
from .mending.topology import edges_of, fans, sheets


def repaired(facets: FacetMesh, *, weld: float = 1e-5, component: str = "all") -> FacetMesh:
    """Weld, drop what is double or collapsed, orient outwards.

    Parameters
    ----------
    facets : FacetMesh
        Triangles as a file gives them.
    weld : float
        Distance within which points of rims are one, over the largest extent of the mesh.
    component : {"all", "largest"}
        Which of several separate surfaces to keep; the largest by area.

    Returns
    -------
    FacetMesh
        At most two triangles at an edge, running it in opposite ways; every point is used.
        Groups, middles and reference follow.

    Raises
    ------
    MeshError
        No triangles left, edges of three or more, one-sided sheets, sheets that cannot be told
        apart; an impossible weld or component.
    """
    if not 0 <= weld < 0.1:
        raise MeshError(f"geometry.weld = {weld:g}: a share of the size, at least 0 and below 0.1")
    if component not in ("all", "largest"):
        raise MeshError(f"geometry.component = {component!r}: 'all' or 'largest'")
    if not len(facets.triangles):
        raise MeshError("no triangles; export a surface of triangles or quads")
    used = facets.points[np.unique(facets.triangles)]
    size = float(np.max(np.ptp(used, axis=0)))
    mesh = Mending(facets, size, weld * size)
    join(mesh)
    _check_edges(mesh)
    _part_touching(mesh)
    _orient(mesh)
    turn_needles(mesh)
    _keep(mesh, component)
    return mesh.result()


def _check_edges(mesh: Mending) -> None:
    """Refuse edges of three or more triangles."""
    triangles = mesh.mesh.triangles
    edges = edges_of(triangles)
    crowded = np.flatnonzero(edges.counts > 2)
    if not len(crowded):
        return
    first = crowded[0]
    around = np.flatnonzero(np.any(edges.of == first, axis=1))
    names = memberships(mesh)
    groups = sorted({name for t in around for name in names[mesh.origin[t]]})
    a, b = (place(mesh.mesh.points[v]) for v in edges.ends[first])
    of = f" of the groups {', '.join(groups)}" if groups else ""
    raise MeshError(
        f"{len(crowded)} edge(s) of three or more triangles, the first from {a} to {b} with "
        f"{edges.counts[first]}{of}; inner walls, tethers and overlapping sheets are not "
        "supported: leave their groups out of geometry.rest, or remove them in a mesh tool"
    )


def _part_touching(mesh: Mending) -> None:
    """Surfaces that touch in a point only get a point each."""
    triangles = mesh.mesh.triangles
    corners = fans(triangles, edges_of(triangles))
    vertices = np.empty(corners.max() + 1, np.int64)
    vertices[corners] = triangles
    extra = len(vertices) - len(np.unique(vertices))
    if not extra:
        return
    _, first = np.unique(vertices, return_index=True)
    new = np.full(len(vertices), -1)
    new[first] = vertices[first]
    fresh = np.flatnonzero(new < 0)
    new[fresh] = len(mesh.mesh.points) + np.arange(extra)
    where = place(mesh.mesh.points[vertices[fresh[0]]])
    points = np.concatenate([mesh.mesh.points, mesh.mesh.points[vertices[fresh]]])
    reference = mesh.mesh.reference
    if reference is not None:
        reference = np.concatenate([reference, reference[vertices[fresh]]])
    mesh.mesh = replace(mesh.mesh, points=points, triangles=new[corners], reference=reference)
    mesh.notes.append(f"{extra} points where surfaces only touch made two, the first at {where}")


def _orient(mesh: Mending) -> None:
    triangles = mesh.mesh.triangles
    edges = edges_of(triangles)
    number, parts = sheets(triangles, edges)
    turned, flat = turns(mesh.mesh.points, triangles, edges, parts)
    closed = np.ones(number, bool)
    closed[parts[np.any(edges.counts[edges.of] == 1, axis=1)]] = False
    if np.any(flat & closed):
        mesh.notes.append(
            f"{np.sum(flat & closed)} closed surfaces of no volume: flat, outwards is as most of "
            "their triangles have it; an opening gives them room"
        )
    middles = mesh.mesh.middles
    if np.any(turned):
        triangles = np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles)
        if middles is not None:
            middles = np.where(turned[:, None, None], middles[:, ::-1], middles)
        mesh.notes.append(f"{np.sum(turned)} of {len(turned)} triangles turned")
    mesh.mesh = replace(mesh.mesh, triangles=triangles, middles=middles)
    if middles is not None:
        _agree(mesh, middles)


def _agree(mesh: Mending, middles: np.ndarray) -> None:
    """Neighbours have one middle of their edge: the mean of theirs."""
    first, second = edges_of(mesh.mesh.triangles).pairs()
    own = middles.reshape(-1, 3).copy()
    apart = np.linalg.norm(own[first] - own[second], axis=1)
    own[first] = own[second] = (own[first] + own[second]) / 2
    mesh.mesh = replace(mesh.mesh, middles=own.reshape(-1, 3, 3))
    if len(apart) and apart.max() > 10 * mesh.distance:
        worst = place(own[first[np.argmax(apart)]])
        mesh.notes.append(
            f"warning: middles of {np.sum(apart > 10 * mesh.distance)} edges differ between their "
            f"triangles, by {apart.max():.3g} at {worst}; their means are taken"
        )


def _keep(mesh: Mending, component: str) -> None:
    """Note several components, or keep the largest."""
    triangles, points = mesh.mesh.triangles, mesh.mesh.points
    number, parts = sheets(triangles)
    if number == 1:
        return
    table = sheet_table(points, triangles, parts, part_volumes(points, triangles, parts))
    order = np.argsort([-sheet.area for sheet in table], kind="stable")
    told = "; ".join(table[i].told() for i in order[:4]) + ("; ..." if number > 4 else "")
    if component == "largest":
        mesh.notes.append(f"largest of {number} components kept ({told})")
        mesh.take(parts == order[0])
    else:
        mesh.notes.append(
            f"{number} components: {told}; geometry.component = 'largest' keeps the first"
        )
