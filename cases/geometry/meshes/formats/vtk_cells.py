"""Cells of VTK's files, old and new: types, offsets and one row of nodes."""

from __future__ import annotations

import numpy as np

from ..facet_mesh import MeshError
from .cells import CellMesh, Cells, labelled

KINDS = {
    1: "vertex", 2: "vertex", 3: "line", 4: "line", 5: "triangle", 7: "polygon", 8: "pixel",
    9: "quad", 10: "tetra", 11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid", 21: "line",
    22: "triangle6", 23: "quad8", 24: "tetra", 25: "hexahedron", 26: "wedge", 27: "pyramid",
    28: "quad9", 29: "hexahedron",
}  # fmt: skip
_NODES = {
    1: 1, 3: 2, 5: 3, 8: 4, 9: 4, 10: 4, 11: 8, 12: 8, 13: 6, 14: 5, 21: 3, 22: 6, 23: 8, 24: 10,
    25: 20, 26: 15, 27: 13, 28: 9, 29: 27,
}  # fmt: skip
_TURNED = {"pixel": ("quad", [0, 1, 3, 2]), "voxel": ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6])}
STRIP, POLYGON = 6, 7


def vtk_mesh(
    points: np.ndarray,
    types: np.ndarray,
    ends: np.ndarray,
    nodes: np.ndarray,
    data: dict[str, np.ndarray],
    notes: list[str],
) -> CellMesh:
    """Cells from the ends of their rows in `nodes`; integer cell data are groups."""
    counts = np.diff(ends, prepend=0)
    if (
        len(types) != len(ends)
        or np.any(counts < 1)
        or (ends[-1] if len(ends) else 0) != len(nodes)
    ):
        raise MeshError("types, offsets and nodes of its cells do not agree: damaged")
    if len(nodes) and (nodes.min() < 0 or nodes.max() >= len(points)):
        cell = int(np.searchsorted(ends, np.argmax((nodes < 0) | (nodes >= len(points))), "right"))
        raise MeshError(f"cell {cell} names a point beyond the {len(points)} of the file (from 0)")
    if np.any(types == STRIP):
        raise MeshError("triangle strips are not read; filter them to triangles first")
    numbers, blocks = np.arange(len(types)), []
    for kind, count in np.unique(np.stack([types, counts], axis=1), axis=0).tolist():
        if _NODES.get(kind, count) != count:
            raise MeshError(f"a cell of VTK's type {kind} with {count} nodes: damaged")
        own = np.flatnonzero((types == kind) & (counts == count))
        rows = nodes[(ends[own] - count)[:, None] + np.arange(count)]
        name = KINDS.get(kind, f"type {kind} of VTK")
        if name == "polygon" and count in (3, 4):
            name = "triangle" if count == 3 else "quad"
        name, order = _TURNED.get(name, (name, list(range(count))))
        blocks.append(Cells(name, rows[:, order], numbers[own]))
    groups: dict[str, np.ndarray] = {}
    left = []
    for name, values in data.items():
        if len(values) != len(types):
            raise MeshError(f"cell data '{name}': {len(values)} values for {len(types)} cells")
        found = labelled(name, values, numbers)
        groups.update(found)
        left += [] if found else [name]
    notes = [*notes, f"cell data left out: {', '.join(left)}"] if left else notes
    return CellMesh(points, blocks, groups, notes=notes)
