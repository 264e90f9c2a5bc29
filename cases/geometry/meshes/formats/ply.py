"""PLY, text and binary of either order; integer properties of the faces are groups.

Elements and properties come in any order; what is not a place or a face is stepped over.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import (
    CellCollector,
    CellMesh,
    Cells,
    flat_kind,
    labelled,
)
from cases.geometry.meshes.formats.cursor import Cursor, integers
from cases.geometry.meshes.formats.text import cut_short

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_FORMATS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_COLOURS = ("red", "green", "blue", "alpha", "flags")


@dataclass
class _Element:
    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)  # name, list count, type


def read(data: bytes) -> CellMesh:
    """Vertices and faces; names of what is left out in the notes."""
    cursor = Cursor(data)
    order, elements = _header(cursor)
    found = {element.name: _columns(cursor, element, order) for element in elements}
    if cursor.data[cursor.place :].strip():
        raise MeshError(
            f"{len(cursor.data) - cursor.place} bytes follow what the header counts: damaged"
        )
    vertices, faces = found.get("vertex", {}), found.get("face", {})
    if not {"x", "y", "z"} <= vertices.keys():
        raise MeshError("its header has no vertices with x, y and z")
    corners = next((faces[name] for name in _CORNERS if name in faces), None)
    if corners is None:
        raise MeshError("its header has no faces (vertex_indices); a point cloud has no surface")
    points = np.column_stack([np.asarray(vertices[k], dtype=float) for k in "xyz"])
    groups, left = {}, [name for name in vertices if name not in "xyz"]
    for name, values in faces.items():
        if name not in _CORNERS:
            labels = {} if name in _COLOURS or isinstance(values, list) else labelled(
                name, values, np.arange(len(values))
            )  # fmt: skip
            groups.update(labels)
            left += [] if labels else [name]
    left += [name for name in found if name not in ("vertex", "face")]
    notes = [f"left out: {', '.join(left)}"] if left else []
    notes += cut_short(data) if order == "=" else []
    return CellMesh(points, _cells(corners, len(points)), groups, notes=notes)


def _cells(corners: np.ndarray | list[np.ndarray], count: int) -> list[Cells]:
    """Faces of equal length at one blow, others one by one."""
    if isinstance(corners, list):
        cells = CellCollector()
        for face, row in enumerate(corners):
            _check(face, row, count)
            cells.add(flat_kind(len(row)), row.tolist())
        return cells.cells()
    bad = np.flatnonzero(np.any((corners < 0) | (corners >= count), axis=1))
    for face in [*bad[:1], *([0] if len(corners) and corners.shape[1] < 3 else [])]:
        _check(face, corners[face], count)
    kind = flat_kind(corners.shape[1])
    return [Cells(kind, corners.astype(np.int64), np.arange(len(corners)))]


def _check(face: int, row: np.ndarray, count: int) -> None:
    if len(row) < 3 or row.min() < 0 or row.max() >= count:
        raise MeshError(f"face {face} names vertices {row.tolist()[:6]} of {count} (from 0)")


def _header(cursor: Cursor) -> tuple[str, list[_Element]]:
    """Byte order ("=" for text) and elements."""
    if cursor.line() != "ply":
        raise MeshError("line 1: 'ply' is expected")
    order, elements = "", list[_Element]()
    while True:
        if cursor.at_end:
            raise MeshError("its header has no 'end_header'")
        where, words = cursor.where(), cursor.line().split()
        match words:
            case ["end_header"]:
                break
            case ["format", name, *_] if name in _FORMATS:
                order = _FORMATS[name]
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count)))
            case ["property", "list", count, kind, name] if {count, kind} <= _TYPES.keys():
                elements[-1].properties.append((name, _TYPES[count], _TYPES[kind]))
            case ["property", kind, name] if kind in _TYPES and elements:
                elements[-1].properties.append((name, "", _TYPES[kind]))
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise MeshError(f"{where}: '{' '.join(words)[:40]}' is no line of a PLY header")
    if not order:
        raise MeshError("its header has no 'format' that is known")
    return order, elements


def _columns(cursor: Cursor, element: _Element, order: str) -> dict:
    """Values of each property: an array, or for a list property a table or a list of arrays."""
    what = f"element {element.name}"
    if element.count * max(len(element.properties), 1) > len(cursor.data):
        raise MeshError(f"{what}: its header counts {element.count}, more than the file holds")
    start = cursor.place
    try:
        columns = _even(cursor, element, order, what)
    except MeshError:
        columns = None
    if columns is None:
        cursor.place = start
        columns = _uneven(cursor, element, order, what)
    return columns


def _even(cursor: Cursor, element: _Element, order: str, what: str) -> dict | None:
    """All rows at one blow, where each list is as long as the first row's."""
    lengths, start = {}, cursor.place
    for name, count, kind in element.properties if element.count else []:
        if count:
            lengths[name] = _some(cursor, order, count, 1, what)[0]
        _some(cursor, order, kind, lengths.get(name, 1), what)
    cursor.place = start
    fields = []
    for name, count, kind in element.properties:
        fields += [(f"n {name}", count, 1)] if count else []
        fields.append((name, kind, int(lengths.get(name, 1))))
    width = sum(many for _, _, many in fields)
    columns, at = {}, 0
    if order == "=":
        words = cursor.numbers("f8", element.count * width, text=True, what=what)
        words = words.reshape(element.count, width)
        for name, kind, many in fields:
            values = words[:, at : at + many]
            columns[name] = values if kind[0] == "f" else integers(values, what)
            at += many
    else:
        kinds = np.dtype([(f"{i}", order + k, (n,)) for i, (_, k, n) in enumerate(fields)])
        size = element.count * kinds.itemsize
        rows = cursor.numbers("u1", size, text=False, what=what).view(kinds)
        columns = {name: rows[f"{i}"] for i, (name, _, _) in enumerate(fields)}
    if any(np.any(columns[f"n {name}"] != many) for name, many in lengths.items()):
        return None
    singles = {p[0]: columns[p[0]][:, 0] for p in element.properties if not p[1]}
    return {p[0]: columns[p[0]] for p in element.properties} | singles


def _uneven(cursor: Cursor, element: _Element, order: str, what: str) -> dict:
    """Row by row."""
    columns: dict = {name: [] for name, _, _ in element.properties}
    for row in range(element.count):
        for name, count, kind in element.properties:
            many = _some(cursor, order, count, 1, f"{what} {row}")[0] if count else 1
            columns[name].append(_some(cursor, order, kind, many, f"{what} {row}"))
    singles = [name for name, count, _ in element.properties if not count and element.count]
    return columns | {name: np.concatenate(columns[name]) for name in singles}


def _some(cursor: Cursor, order: str, kind: str, many: int, what: str) -> np.ndarray:
    text = order == "="
    kind = f"{kind[0].replace('u', 'i')}8" if text else order + kind
    return cursor.numbers(kind, many, text=text, what=what)
