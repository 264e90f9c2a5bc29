"""Wavefront OBJ: vertices and faces with any slashes, relative indices, objects and groups."""

from __future__ import annotations

from collections import Counter

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import CellCollector, CellMesh, flat_kind
from cases.geometry.meshes.formats.text import clean_name, cut_short, real, text_of, whole

_KNOWN = ("vt", "vn", "vp", "s", "mtllib", "mg", "cstype", "deg")
_FREEFORM = (
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bmat",
    "step",
)


def read(data: bytes) -> CellMesh:
    """Faces with the names of their object (o), groups (g) and material (usemtl)."""
    points: list[list[float]] = []
    cells, spaces = CellCollector(), {"o": [""], "g": [""], "usemtl": [""]}
    left: Counter[str] = Counter()
    materials: set[str] = set()
    names: set[str] = set()
    for number, words in _lines(text_of(data)):
        key, rest = words[0], words[1:]
        if key == "v":
            if len(rest) < 3:
                raise MeshError(f"line {number}: a vertex of {len(rest)} coordinates")
            points.append([real(word, number) for word in rest[:3]])
        elif key == "f":
            corners = [_corner(word, len(points), number) for word in rest]
            if len(corners) < 3:
                raise MeshError(f"line {number}: a face of {len(corners)} corners")
            belongs = [f"{k} {name}" for k, found in spaces.items() for name in found if name]
            cells.add(flat_kind(len(corners)), corners, belongs)
        elif key in spaces:
            found = rest if key == "g" else [" ".join(rest)]
            spaces[key] = [clean_name(name) for name in found]
            (materials if key == "usemtl" else names).update(spaces[key])
        elif key in ("l", "p"):
            left["lines" if key == "l" else "points"] += 1
        elif key in _FREEFORM:
            left["free-form surfaces"] += 1
        elif key not in _KNOWN:
            raise MeshError(f"line {number}: '{clean_name(key)[:24]}' is no word of an OBJ file")
    notes = [f"{count} {what} left out" for what, count in left.items()]
    groups: dict[str, np.ndarray] = {}
    for key, numbers in cells.groups().items():
        space, _, name = key.partition(" ")
        name = f"{name} (material)" if space == "usemtl" and name in names else name
        groups[name] = np.union1d(groups.get(name, numbers), numbers)
    found = cells.cells()
    table = np.array(points, dtype=float).reshape(-1, 3)
    for block in found:
        beyond = np.argwhere(block.nodes >= len(table))
        if len(beyond):
            corner = block.nodes[tuple(beyond[0])] + 1
            raise MeshError(f"a face names vertex {corner}, the file has {len(table)}")
    return CellMesh(table, found, groups, notes=[*notes, *cut_short(data)])


def _lines(text: str):  # type: ignore[no-untyped-def]
    """Numbers and words of the lines that say something; a backslash joins the next one."""
    joined: list[str] = []
    first = 0
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.partition("#")[0].rstrip()
        first = first if joined else number
        if line.endswith("\\"):
            joined.append(line[:-1])
            continue
        words, joined = " ".join([*joined, line]).split(), []
        if words:
            yield first, words


def _corner(word: str, count: int, line: int) -> int:
    """Index of a corner's vertex; negative ones count back from the last vertex so far."""
    index = whole(word.partition("/")[0], line)
    if index == 0 or index < -count:
        raise MeshError(f"line {line}: a face names vertex {index}, {count} are given so far")
    return index - 1 if index > 0 else count + index
