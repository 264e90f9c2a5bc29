"""STL, text and binary: a soup of triangles; solids are groups.

Binary where its count agrees with its length, whatever its header says: many begin with "solid".
"""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np

from ..facet_mesh import MeshError
from .cells import CellMesh, Cells
from .text import clean_name

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84
_SOLID = re.compile(rb"^[ \t]*(solid|endsolid)\b([^\r\n]*)", re.MULTILINE | re.IGNORECASE)
_FACET = (
    b"facet normal . . . outer loop vertex . . . vertex . . . vertex . . . endloop endfacet".split()
)
_WORDS = np.flatnonzero([word != b"." for word in _FACET])
_LAST = re.compile(rb"endfacet", re.IGNORECASE)
_CHUNK = 1 << 23
_CORNERS = np.array([8, 9, 10, 12, 13, 14, 16, 17, 18])


def read(data: bytes) -> CellMesh:
    """Points (3 m, 3) in the order of the corners."""
    count = int.from_bytes(data[80:84], "little") if len(data) >= _HEAD else -1
    if count >= 0 and len(data) == _HEAD + _RECORD.itemsize * count:
        return _binary(data, count)
    if data.lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        return _text(data)
    if len(data) < _HEAD or b"\0" not in data:
        raise MeshError("not an STL file: neither 'solid' at its start nor a binary header")
    held = (len(data) - _HEAD) / _RECORD.itemsize
    if held > count > 0:
        mesh = _binary(data, count)
        extra = len(data) - _HEAD - _RECORD.itemsize * count
        return _soup(mesh.points, {}, [*mesh.notes, f"{extra} bytes after the last facet"])
    raise MeshError(
        f"binary STL of {count} triangles by its header, room for {held:.1f} in the file: cut "
        "short or damaged; export or copy it again"
    )


def _soup(points: np.ndarray, groups: dict, notes: list[str]) -> CellMesh:
    cells = np.arange(len(points)).reshape(-1, 3)
    return CellMesh(points, [Cells("triangle", cells, np.arange(len(cells)))], groups, notes=notes)


def _binary(data: bytes, count: int) -> CellMesh:
    records = np.frombuffer(data, _RECORD, count, _HEAD)
    notes = ["attribute bytes (colours?) left out"] if np.any(records["attribute"]) else []
    return _soup(records["corners"].reshape(-1, 3).astype(float), {}, notes)


def _text(data: bytes) -> CellMesh:
    marks = list(_SOLID.finditer(data))
    if marks[-1][1].lower() != b"endsolid":
        raise MeshError(
            f"ends at byte {len(data)} without 'endsolid': cut short; export or copy it again"
        )
    blocks, names = [], []
    for mark, after in pairwise(marks):
        body = data[mark.end() : after.start()]
        if mark[1].lower() == b"endsolid":
            if body.strip():
                raise MeshError(f"line {_line(data, mark.end())}: text between two solids")
            continue
        blocks.append(_facets(data, mark.end(), body))
        names.append(clean_name(mark[2].decode("utf-8", "replace")))
    if data[marks[-1].end() :].strip():
        raise MeshError(f"line {_line(data, marks[-1].end()) + 1}: text after the last 'endsolid'")
    starts = np.cumsum([0, *map(len, blocks)])
    groups: dict[str, np.ndarray] = {}
    for i, name in enumerate(names):
        if name or len(names) > 1:
            key, numbers = name or f"solid {i + 1}", np.arange(starts[i], starts[i + 1])
            groups[key] = np.concatenate([groups.get(key, numbers[:0]), numbers])
    return _soup(np.concatenate(blocks).reshape(-1, 3), groups, [])


def _facets(data: bytes, start: int, body: bytes) -> np.ndarray:
    """Corners (m, 9) of one solid's text, a few megabytes at a time."""
    done, blocks, at = 0, [np.empty((0, 9))], 0
    while at < len(body):
        mark = _LAST.search(body, at + _CHUNK)
        stop = mark.end() if mark else len(body)
        words = body[at:stop].split()
        whole = len(words) // len(_FACET) * len(_FACET)
        table = np.array(words[:whole], dtype=bytes).reshape(-1, len(_FACET))
        fixed = np.char.lower(table[:, _WORDS]) == np.array(_FACET)[_WORDS]
        bad = np.flatnonzero(~np.all(fixed, axis=1))
        if len(bad) or whole < len(words):
            facet = done + (bad[0] if len(bad) else len(table))
            raise MeshError(
                f"facet {facet + 1} of the solid at line {_line(data, start)} is not 'facet normal "
                "x y z', 'outer loop' of three 'vertex' lines, 'endloop', 'endfacet'"
            )
        try:
            blocks.append(table[:, _CORNERS].astype(float))
        except ValueError as error:
            raise MeshError(
                f"solid at line {_line(data, start)}: a vertex is no number ({error})"
            ) from None
        done, at = done + len(table), stop
    return np.concatenate(blocks)


def _line(data: bytes, place: int) -> int:
    return data.count(b"\n", 0, place) + 1
