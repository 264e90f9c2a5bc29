"""Legacy VTK (.vtk), text and big-endian binary: unstructured grids and polygons."""

from __future__ import annotations

import re

import numpy as np

from ..facet_mesh import MeshError
from .cells import CellMesh
from .cursor import Cursor
from .text import clean_name, cut_short
from .vtk_cells import POLYGON, STRIP, vtk_mesh

_TYPES = {
    "unsigned_char": "u1", "char": "i1", "unsigned_short": "u2", "short": "i2", "int": "i4",
    "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "vtkidtype": "i4",
    "vtktypeint64": "i8", "vtktypeint32": "i4", "vtktypeuint8": "u1", "float": "f4", "double": "f8",
}  # fmt: skip
_WIDTHS = {
    "VECTORS": 3,
    "NORMALS": 3,
    "TENSORS": 9,
    "TENSORS6": 6,
    "GLOBAL_IDS": 1,
    "PEDIGREE_IDS": 1,
}
# what holds cells of polygonal data: type of VTK, 0 where the number of nodes decides
_POLYGONAL = {"VERTICES": 2, "LINES": 4, "POLYGONS": POLYGON, "TRIANGLE_STRIPS": STRIP}


class _Legacy:
    """A file on its way through its sections."""

    def __init__(self, data: bytes) -> None:
        self.cursor = Cursor(data)
        self.text = True
        self.points: np.ndarray | None = None
        self.types: list[np.ndarray] = []
        self.ends: list[np.ndarray] = []
        self.nodes: list[np.ndarray] = []
        self.data: dict[str, np.ndarray] = {}
        self.left: list[str] = []
        self.owner, self.count = "", 0

    def array(self, kind: str, count: int, what: str) -> np.ndarray:
        """Numbers of a named type."""
        if kind.lower() not in _TYPES:
            raise MeshError(f"{self.cursor.where()}: numbers of type '{clean_name(kind)[:24]}'")
        code = _TYPES[kind.lower()]
        if self.text:
            code = f"{code[0].replace('u', 'i')}8"
        return self.cursor.numbers(f">{code}", count, text=self.text, what=what)

    def keep(self, name: str, values: np.ndarray) -> None:
        """Data of cells; all else is named as left out."""
        if self.owner == "CELL_DATA":
            self.data[name] = values
        else:
            self.left.append(name)

    def cells(self, kind: int | None, first: int, second: int) -> None:
        """Rows of nodes, each with its length in front (before 5.0) or by offsets."""
        start = self.cursor.place
        head = self.cursor.full_line().split() if second or first else []
        if head[:1] == ["OFFSETS"]:
            ends = self.array(head[1], first, "offsets").astype(np.int64)
            head = self.cursor.full_line().split()
            if head[:1] != ["CONNECTIVITY"] or ends[:1].tolist() != [0]:
                raise MeshError(f"{self.cursor.where()}: CONNECTIVITY is expected after OFFSETS")
            nodes, ends = self.array(head[1], second, "cells").astype(np.int64), ends[1:]
        else:
            self.cursor.place = start
            ends, nodes = _rows(self.array("int", second, "cells").astype(np.int64), first)
        if np.any(np.diff(ends, prepend=0) < 0) or (ends[-1] if len(ends) else 0) != len(nodes):
            raise MeshError("rows of its cells do not agree with their counts: damaged")
        self.ends.append(ends + sum(map(len, self.nodes)))
        self.nodes.append(nodes)
        if kind is not None:
            self.types.append(np.full(len(ends), kind))


def read(data: bytes) -> CellMesh:
    """Points and cells; integer cell data are groups."""
    if not re.match(rb"# vtk DataFile Version \d", data):
        raise MeshError("line 1: '# vtk DataFile Version' is expected")
    file = _Legacy(data)
    file.cursor.line(), file.cursor.line()
    form = file.cursor.line().upper()
    if form not in ("ASCII", "BINARY"):
        raise MeshError(f"line 3: ASCII or BINARY is expected, not '{clean_name(form)[:24]}'")
    file.text = form == "ASCII"
    while words := file.cursor.full_line().split():
        _section(file, words[0].upper(), words[1:])
    if file.points is None or not file.ends:
        raise MeshError("no POINTS or no cells in it: cut short, or no surface")
    notes = [f"data left out: {', '.join(dict.fromkeys(file.left))}"] if file.left else []
    notes += cut_short(data) if file.text else []
    types = np.concatenate(file.types) if file.types else np.empty(0, int)
    return vtk_mesh(
        file.points, types, np.concatenate(file.ends), np.concatenate(file.nodes), file.data, notes
    )


def _section(file: _Legacy, key: str, rest: list[str]) -> None:
    cursor = file.cursor
    try:
        if key == "DATASET":
            if rest[0].upper() not in ("UNSTRUCTURED_GRID", "POLYDATA"):
                raise MeshError(f"data set '{rest[0][:24]}': save an unstructured grid or polygons")
        elif key == "POINTS":
            count = int(rest[0])
            file.points = file.array(rest[1], 3 * count, "points").reshape(-1, 3).astype(float)
        elif key == "CELLS" or key in _POLYGONAL:
            file.cells(_POLYGONAL.get(key), int(rest[0]), int(rest[1]))
        elif key == "CELL_TYPES":
            file.types.append(file.array("int", int(rest[0]), "cell types"))
        elif key in ("POINT_DATA", "CELL_DATA"):
            file.owner, file.count = key, int(rest[0])
        elif key == "SCALARS":
            width = int(rest[2]) if len(rest) > 2 else 1
            place = cursor.place
            if not cursor.full_line().startswith("LOOKUP_TABLE"):
                cursor.place = place
            values = file.array(rest[1], width * file.count, rest[0])
            file.keep(rest[0], values if width == 1 else values.reshape(-1, width))
        elif key in _WIDTHS:
            values = file.array(rest[1], _WIDTHS[key] * file.count, rest[0])
            file.keep(rest[0], values.reshape(file.count, -1))
        elif key == "TEXTURE_COORDINATES":
            file.array(rest[2], int(rest[1]) * file.count, rest[0])
        elif key == "COLOR_SCALARS":
            file.array(
                "float" if file.text else "unsigned_char", int(rest[1]) * file.count, rest[0]
            )
            file.left.append(rest[0])
        elif key == "LOOKUP_TABLE":
            file.array("float" if file.text else "unsigned_char", 4 * int(rest[1]), rest[0])
        elif key == "FIELD":
            _field(file, int(rest[1]))
        elif key == "METADATA":
            while cursor.line():
                pass
        else:
            raise MeshError(f"{cursor.where()}: '{clean_name(key)[:24]}' is no section of VTK")
    except (IndexError, ValueError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{cursor.where()}: section {key} is unreadable: damaged") from None


def _field(file: _Legacy, count: int) -> None:
    """Arrays of a FIELD, with their own lengths."""
    for _ in range(count):
        words = file.cursor.full_line().split()
        if words[:1] == ["METADATA"]:
            while file.cursor.line():
                pass
            words = file.cursor.full_line().split()
        name, width, rows, kind = words
        if kind == "string":
            for _ in range(int(rows) * int(width)):
                file.cursor.line()
            continue
        values = file.array(kind, int(width) * int(rows), name)
        file.keep(name, values if int(width) == 1 else values.reshape(int(rows), -1))


def _rows(table: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Ends and nodes of rows that begin with their length."""
    starts, at = np.empty(count, np.int64), 0
    for row in range(count):
        if at >= len(table) or table[at] < 0:
            raise MeshError(f"cell {row} of {count} is missing: damaged")
        starts[row] = at
        at += int(table[at]) + 1
    if at != len(table):
        raise MeshError(f"{count} cells take {at} numbers, {len(table)} are given: damaged")
    keep = np.ones(len(table), bool)
    keep[starts] = False
    return np.cumsum(table[starts]), table[keep]
