"""All triangles of a sheet the same way round, and closed sheets outwards.

Each triangle is two nodes of a graph, as it stands and turned; an edge links equal nodes of its
triangles where they agree, opposite ones where not. Both nodes in one part: a one-sided sheet.
"""

from __future__ import annotations

import numpy as np

from ..facet_mesh import MeshError, place
from ..flat_triangles import facet_areas
from .topology import FacetEdges, boundary_loops, two_sided

# Volume of a sheet, over its area to the power 3/2, below which it is flat.
FLAT = 1e-8


def turns(
    points: np.ndarray, triangles: np.ndarray, edges: FacetEdges, parts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which triangles (m,) to turn so that those of each part agree and enclose a volume.

    Parts that enclose none, named by the second result, keep the way that most of their triangles
    have.

    Raises
    ------
    MeshError
        A one-sided sheet (Moebius, Klein), naming an edge.
    """
    first, second = edges.pairs()
    way = edges.forward.ravel()
    against = way[first] == way[second]
    m = len(triangles)
    kept, other = two_sided(m, first // 3, second // 3, against)
    single = np.flatnonzero(kept == other)
    if len(single):
        raise MeshError(_one_sided(points, triangles, edges, parts == parts[single[0]]))
    # of the two nodes the one that is in the part of the sheet's first triangle as it stands
    start = np.full(parts.max() + 1, m)
    np.minimum.at(start, parts, np.arange(m))
    turned = kept != kept[start[parts]]
    volume, area = _signed(points, triangles, turned, parts)
    many = np.bincount(parts, turned) > 0.5 * np.bincount(parts)
    flat = np.abs(volume) <= FLAT * area**1.5
    return turned ^ np.where(flat, many, volume < 0)[parts], flat


def part_volumes(points: np.ndarray, triangles: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Volume that each part encloses, its holes closed by fans."""
    return _signed(points, triangles, np.zeros(len(triangles), bool), parts)[0]


def _signed(points, triangles, turned, parts):  # type: ignore[no-untyped-def]
    """Volume and area of each part."""
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    number = int(parts.max()) + 1
    origin = np.stack(
        [np.bincount(parts, points[triangles].mean(axis=1)[:, k], number) for k in range(3)], axis=1
    ) / np.bincount(parts, minlength=number).reshape(-1, 1)
    a, b, c = (points[triangles[:, k]] - origin[parts] for k in range(3))
    volume = np.bincount(parts, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, number)
    area = facet_areas(points, triangles)
    owner = np.zeros(len(points), int)
    owner[triangles] = parts[:, None]
    for loop in boundary_loops(triangles):
        part = owner[loop[0]]
        rim = points[loop] - origin[part]
        fan = np.cross(np.roll(rim, -1, axis=0), rim) @ rim.mean(axis=0)
        volume[part] += fan.sum() / 6
    return volume, np.bincount(parts, area, number)


def _one_sided(
    points: np.ndarray, triangles: np.ndarray, edges: FacetEdges, own: np.ndarray
) -> str:
    """Words on an edge whose triangles cannot agree once all others of a tree do."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    first, second = edges.pairs()
    inside = own[first // 3]
    first, second = first[inside], second[inside]
    way = edges.forward.ravel()
    against = way[first] == way[second]
    m, f, g = len(triangles), first // 3, second // 3
    links = coo_array((np.ones(len(f)), (f, g)), (m, m)).tocsr()
    order, before = breadth_first_order(links, int(np.flatnonzero(own)[0]), directed=False)
    differ = dict(zip(zip(f.tolist(), g.tolist(), strict=True), against.tolist(), strict=True))
    sign = np.zeros(m, bool)
    for t in order[1:].tolist():
        b = int(before[t])
        sign[t] = sign[b] ^ differ.get((t, b), differ.get((b, t), False))
    bad = np.flatnonzero(sign[f] ^ sign[g] ^ against)[0]
    ends = points[edges.ends[edges.of.ravel()[first[bad]]]]
    start, stop = (place(end) for end in ends)
    return (
        f"a sheet of {np.sum(own)} triangles has one side only (Moebius or Klein): its triangles "
        f"cannot agree at the edge from {start} to {stop}; cut or remodel it there"
    )
