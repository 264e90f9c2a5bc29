"""Cells of a file cut into triangles: quads along the shorter diagonal, polygons by ears.

Solids give their boundary where the file has no surface; lines and points are named and left out.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from .facet_mesh import FacetMesh, MeshError
from .flat_triangles import plane_cross
from .formats.cells import CellMesh, Cells

MOST_TRIANGLES = 2_000_000
MOST_CORNERS = 500
_FLAT = ("triangle", "triangle6", "quad", "quad8", "quad9", "polygon")
_SECOND = ("triangle6", "quad8", "quad9")
# faces of solids, seen from outside
_FACES = {
    "tetra": ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]),
    "pyramid": ([0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]),
    "wedge": ([0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]),
    "hexahedron": (
        [0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7],
    ),
}  # fmt: skip


def faceted(mesh: CellMesh) -> FacetMesh:
    """Triangles of a file in its order, with its groups; refused where there are none."""
    _check_finite(mesh)
    counts = Counter[str]()
    for block in mesh.cells:
        counts[block.kind] += len(block.nodes)
    flat = [block for block in mesh.cells if block.kind in _FLAT and len(block.nodes)]
    notes, taken = list(mesh.notes), set(_FLAT)
    if not flat:
        taken = set(_FACES)
        flat = _boundary([block for block in mesh.cells if block.kind in _FACES])
        if flat:
            solids = ", ".join(f"{counts[kind]} {kind}" for kind in _FACES if counts[kind])
            notes.append(f"boundary taken of the solids ({solids})")
    if not flat:
        held = ", ".join(f"{n} {kind}" for kind, n in counts.items()) or "points only"
        raise MeshError(f"no triangles in it but {held}; export a surface of triangles or quads")
    left = [f"{n} {kind}" for kind, n in counts.items() if kind not in taken]
    notes += [f"cells left out: {', '.join(left)}"] if left else []
    pieces = [_triangles(mesh.points, block, notes) for block in flat]
    numbers = np.concatenate([piece[1] for piece in pieces])
    order = np.argsort(numbers, kind="stable")
    triangles = np.concatenate([piece[0] for piece in pieces])[order]
    if len(triangles) > MOST_TRIANGLES:
        raise MeshError(
            f"{len(triangles)} triangles, {MOST_TRIANGLES} at most; decimate it in a mesh tool"
        )
    middles = None
    if any(piece[2] is not None for piece in pieces):
        middles = np.concatenate([_middles(mesh.points, *piece[::2]) for piece in pieces])[order]
    groups = _groups(mesh, numbers[order], notes)
    corners = _without_middles(mesh, triangles)
    reference = None if mesh.reference is None else mesh.reference[corners]
    triangles = np.searchsorted(corners, triangles)
    return FacetMesh(
        mesh.points[corners], triangles, groups, middles, reference, tuple(dict.fromkeys(notes))
    )


def _check_finite(mesh: CellMesh) -> None:
    for what, table in (("coordinates", mesh.points), ("reference", mesh.reference)):
        if table is not None and not np.all(np.isfinite(table)):
            row = int(np.flatnonzero(~np.all(np.isfinite(table), axis=1))[0])
            label = row + 1 if mesh.labels is None else mesh.labels[row]
            raise MeshError(
                f"{what} of point {label} are {table[row].tolist()}, not finite; mend or remove it"
            )
    if len(mesh.points) and np.max(np.abs(mesh.points)) > 1e100:
        row = int(np.argmax(np.max(np.abs(mesh.points), axis=1)))
        label = row + 1 if mesh.labels is None else mesh.labels[row]
        raise MeshError(f"point {label} lies at {mesh.points[row].tolist()}: damaged")


def _without_middles(mesh: CellMesh, triangles: np.ndarray) -> np.ndarray:
    """Points that are no middles of second-order cells, or corners too."""
    keep = np.ones(len(mesh.points), bool)
    for block in mesh.cells:
        if block.kind in _SECOND:
            keep[block.nodes[:, 3 if block.kind == "triangle6" else 4 :]] = False
    keep[triangles] = True
    return np.flatnonzero(keep)


def _groups(mesh: CellMesh, owners: np.ndarray, notes: list[str]) -> dict[str, np.ndarray]:
    """Triangles of each group; groups without any are named."""
    groups, empty = {}, []
    for name, numbers in mesh.groups.items():
        found = np.flatnonzero(np.isin(owners, numbers))
        if len(found):
            groups[name] = found
        else:
            empty.append(f"'{name}' ({len(numbers)} cells)")
    if empty:
        notes.append(f"groups without triangles left out: {', '.join(empty)}")
    return groups


def _triangles(points: np.ndarray, block: Cells, notes: list[str]):  # type: ignore[no-untyped-def]
    """Triangles (k, 3), their cells' numbers, and middles (k, 3, 3) of second-order ones."""
    nodes = block.nodes
    if block.kind == "triangle":
        return nodes, block.numbers, None
    if block.kind == "triangle6":
        return nodes[:, :3], block.numbers, points[nodes[:, 3:6]]
    if block.kind == "polygon":
        cut = [_ears(points, row) for row in nodes]
        notes.append(f"{len(nodes)} polygons of {nodes.shape[1]} corners cut into triangles")
        return np.concatenate(cut), np.repeat(block.numbers, [len(c) for c in cut]), None
    return _split(points, block, notes)


def _split(points: np.ndarray, block: Cells, notes: list[str]):  # type: ignore[no-untyped-def]
    """Quads along their shorter diagonal; those with a repeated corner are triangles."""
    quads, numbers, extra = block.nodes[:, :4], block.numbers, block.nodes[:, 4:]
    same = quads == np.roll(quads, -1, axis=1)
    single = np.any(same, axis=1)
    if np.any(single):
        notes.append(f"{np.sum(single)} quads with a repeated corner taken as triangles")
    rolled = np.argmax(same[single], axis=1)[:, None] + np.arange(1, 4)
    lone = np.take_along_axis(quads[single], rolled % 4, axis=1)
    corners, whole = points[quads[~single]], quads[~single]
    lengths = np.linalg.norm(corners[:, :2] - corners[:, 2:], axis=2)
    # equal diagonals of a lattice differ by rounding: the first one then, everywhere
    turn = (lengths[:, 1] < lengths[:, 0] * (1 - 1e-9)).astype(int)
    order = (np.arange(4) + turn[:, None]) % 4
    whole = np.take_along_axis(whole, order, axis=1)
    pairs = whole[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    if len(pairs):
        notes.append(f"{len(whole)} quads split along the shorter diagonal")
    triangles = np.concatenate([pairs, lone])
    owners = np.concatenate([np.repeat(numbers[~single], 2), numbers[single]])
    if not extra.shape[1]:
        return triangles, owners, None
    if np.any(single):
        raise MeshError("second-order quads with a repeated corner are not read; export order 1")
    middles = np.take_along_axis(points[extra[:, :4]], order[:, :, None], axis=1)
    centre = middles.sum(axis=1) / 2 - points[whole].sum(axis=1) / 4
    centre = points[extra[:, 4]] if extra.shape[1] > 4 else centre
    first = np.stack([middles[:, 0], middles[:, 1], centre], axis=1)
    second = np.stack([centre, middles[:, 2], middles[:, 3]], axis=1)
    return triangles, owners, np.stack([first, second], axis=1).reshape(-1, 3, 3)


def _middles(points: np.ndarray, triangles: np.ndarray, middles: np.ndarray | None) -> np.ndarray:
    """Middles of second-order triangles, of straight edges for the others."""
    if middles is not None:
        return middles
    corners = points[triangles]
    return (corners + np.roll(corners, -1, axis=1)) / 2


def _ears(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Triangles of one polygon, cutting the ear of the shortest diagonal each time."""
    if len(polygon) > MOST_CORNERS:
        raise MeshError(f"a face of {len(polygon)} corners, {MOST_CORNERS} at most; triangulate it")
    corners = points[polygon] - points[polygon[0]]
    normal = np.sum(np.cross(corners, np.roll(corners, -1, axis=0)), axis=0)
    axis = np.linalg.svd(np.atleast_2d(normal))[2]
    flat = corners @ axis[1:].T
    if np.dot(np.cross(axis[1], axis[2]), normal) < 0:
        flat = flat[:, ::-1]
    ring, cut = list(range(len(polygon))), []
    while len(ring) > 3:
        at = np.array(ring)
        before, after = flat[np.roll(at, 1)], flat[np.roll(at, -1)]
        convex = plane_cross(flat[at] - before, after - flat[at]) > 0
        lengths = np.where(convex, np.linalg.norm(after - before, axis=1), np.inf)
        best = int(np.argmin(lengths))
        for i in np.argsort(lengths):
            others = flat[np.delete(at, [i, i - 1, (i + 1) % len(at)])]
            if np.isfinite(lengths[i]) and not np.any(
                _inside(others, before[i], flat[at[i]], after[i])
            ):
                best = int(i)
                break
        cut.append([ring[best - 1], ring[best], ring[(best + 1) % len(ring)]])
        del ring[best]
    return polygon[np.array([*cut, ring])]


def _inside(points: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Which points lie in the triangle, its edges included."""
    sides = [plane_cross(q - p, points - p) for p, q in ((a, b), (b, c), (c, a))]
    return np.all(np.array(sides) >= 0, axis=0)


def _boundary(solids: list[Cells]) -> list[Cells]:
    """Faces that belong to one solid only, with their solids' numbers."""
    rows, owners = [], []
    for block in solids:
        for face in _FACES[block.kind]:
            row = np.full((len(block.nodes), 4), -1, np.int64)
            row[:, : len(face)] = block.nodes[:, face]
            rows.append(row)
            owners.append(block.numbers)
    if not rows:
        return []
    faces, numbers = np.concatenate(rows), np.concatenate(owners)
    _, inverse, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    outer = counts[inverse.ravel()] == 1
    three = outer & (faces[:, 3] < 0)
    four = outer & (faces[:, 3] >= 0)
    found = [
        Cells("triangle", faces[three, :3], numbers[three]),
        Cells("quad", faces[four], numbers[four]),
    ]
    return [block for block in found if len(block.nodes)]
