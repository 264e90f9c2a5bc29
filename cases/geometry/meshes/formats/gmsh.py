"""Gmsh meshes, versions 2.2 and 4.1, text and binary; physical names are groups.

A physical number without a name is the group "physical 7"; of both dimensions: cells keep theirs.
"""

from __future__ import annotations

import re
from collections import defaultdict

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import CellMesh, Cells, distinct, places
from cases.geometry.meshes.formats.cursor import Cursor, integers
from cases.geometry.meshes.formats.text import clean_name

# type: kind, nodes, dimension
_TYPES = {
    1: ("line", 2, 1), 2: ("triangle", 3, 2), 3: ("quad", 4, 2), 4: ("tetra", 4, 3),
    5: ("hexahedron", 8, 3), 6: ("wedge", 6, 3), 7: ("pyramid", 5, 3), 8: ("line", 3, 1),
    9: ("triangle6", 6, 2), 10: ("quad9", 9, 2), 11: ("tetra", 10, 3), 12: ("hexahedron", 27, 3),
    13: ("wedge", 18, 3), 14: ("pyramid", 14, 3), 15: ("vertex", 1, 0), 16: ("quad8", 8, 2),
    17: ("hexahedron", 20, 3), 18: ("wedge", 15, 3), 19: ("pyramid", 13, 3), 26: ("line", 4, 1),
    20: ("triangle of order 3", 9, 2), 21: ("triangle of order 3", 10, 2),
    22: ("triangle of order 4", 12, 2), 23: ("triangle of order 4", 15, 2),
    36: ("quad of order 3", 16, 2), 37: ("quad of order 4", 25, 2), 29: ("tetra", 20, 3),
}  # fmt: skip
_MARK = re.compile(rb"^\$(\w+)[ \t\r]*\n", re.MULTILINE)
_NAME = re.compile(r'\s*(\d+)\s+(-?\d+)\s+"(.*)"\s*$')


def read(data: bytes) -> CellMesh:
    """Points and cells of all dimensions."""
    head = re.match(rb"\s*\$MeshFormat\s+([\d.]+)\s+([01])\s+(\d+)[ \t\r]*\n", data)
    if not head:
        raise MeshError("not a Gmsh mesh: '$MeshFormat' is expected at its start")
    version, text = head[1].decode(), head[2] == b"0"
    if not text and data[head.end() : head.end() + 4] != b"\1\0\0\0":
        raise MeshError("binary of the other byte order; save it as text")
    sections = _sections(data, head.end(), text)
    for name in ("Nodes", "Elements"):
        if name not in sections:
            raise MeshError(f"no section ${name}: cut short, or saved without its mesh")
    if version.startswith("2"):
        return _version_2(sections, text)
    if version in ("4.1", "4"):
        return _version_4(sections, text, int(head[3]))
    raise MeshError(f"version {version} of Gmsh's format is not read; save it as 2.2 or 4.1")


def _sections(data: bytes, place: int, text: bool) -> dict[str, Cursor]:
    """Insides of the sections by name; each must be closed by its $End mark."""
    found = {}
    while mark := _MARK.search(data, place):
        name = mark[1].decode()
        if name.startswith("End"):
            place = mark.end()
            continue
        end = re.compile(rb"(?<=\n)?\$End" + mark[1] + rb"\b").search(data, mark.end())
        if not end:
            raise MeshError(f"section ${name} is not closed: cut short; export or copy it again")
        if name in found:
            raise MeshError(f"two sections ${name}; save one mesh a file")
        found[name] = Cursor(data[: end.start()], mark.end())
        place = end.end()
    return found


def _names(sections: dict[str, Cursor]) -> dict[tuple[int, int], str]:
    """Names by dimension and number."""
    names = {}
    if cursor := sections.get("PhysicalNames"):
        cursor.full_line()
        while line := cursor.full_line():
            if not (match := _NAME.match(line)):
                raise MeshError(f"$PhysicalNames: '{clean_name(line)[:40]}' is no name")
            names[int(match[1]), int(match[2])] = clean_name(match[3])
    return names


def _type(number: int) -> tuple[str, int, int]:
    if number not in _TYPES:
        raise MeshError(f"elements of Gmsh's type {number} are not read; save order 1 or 2")
    return _TYPES[number]


def _version_2(sections: dict[str, Cursor], text: bool) -> CellMesh:
    nodes, elements = sections["Nodes"], sections["Elements"]
    count = _count(nodes)
    if text:
        table = nodes.numbers(float, 4 * count, text=True, what="nodes").reshape(-1, 4)
        ids, points = integers(table[:, 0], "nodes"), table[:, 1:]
    else:
        rows = nodes.numbers("u1", 28 * count, text=False, what="nodes")
        records = rows.view(np.dtype([("id", "<i4"), ("x", "<f8", 3)]))
        ids, points = records["id"].astype(np.int64), records["x"]
    rows_of: dict[int, list] = defaultdict(list)  # type: number, physical, nodes
    total = _count(elements)
    read_rows = _text_elements if text else _binary_elements
    for kind, numbers, physical, cells in read_rows(elements, total):
        rows_of[kind].append((numbers, physical, cells))
    _finished(nodes, "Nodes")
    _finished(elements, "Elements")
    blocks, labels = [], defaultdict(list)
    for kind, parts in rows_of.items():
        numbers, physical, cells = (np.concatenate(column) for column in zip(*parts, strict=True))
        name, _, dimension = _type(kind)
        blocks.append((name, cells, numbers))
        for label in np.unique(physical):
            labels[dimension, abs(int(label))].append(numbers[physical == label])
    return _mesh(ids, points, blocks, labels, _names(sections))


def _text_elements(cursor: Cursor, total: int):  # type: ignore[no-untyped-def]
    """Blocks of elements from lines; neighbours of one type and number of tags together."""
    rows: dict[tuple[int, int], list[list[int]]] = defaultdict(list)
    order: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number in range(total):
        words = cursor.full_line().split()
        try:
            row = [int(word) for word in words]
            kind, tags = row[1], row[2]
        except (ValueError, IndexError):
            raise MeshError(
                f"$Elements: the line of element {number + 1} of {total} is unreadable: damaged"
            ) from None
        if tags < 0 or len(row) != 3 + tags + _type(kind)[1]:
            raise MeshError(
                f"element {row[0]}: {len(row)} numbers, not {3 + tags + _type(kind)[1]}"
            )
        rows[kind, tags].append(row)
        order[kind, tags].append(number)
    for (kind, tags), block in rows.items():
        table = np.array(block)
        physical = table[:, 3] if tags else np.zeros(len(table), int)
        yield kind, np.array(order[kind, tags]), physical, table[:, 3 + tags :]


def _binary_elements(cursor: Cursor, total: int):  # type: ignore[no-untyped-def]
    """Blocks of elements with their headers."""
    done = 0
    while done < total:
        kind, count, tags = cursor.numbers("<i4", 3, text=False, what="elements").tolist()
        if count < 1 or tags < 0 or count > total - done:
            raise MeshError(f"$Elements: a block of {count} elements, {total - done} are left")
        width = 1 + tags + _type(kind)[1]
        table = cursor.numbers("<i4", count * width, text=False, what="elements").reshape(-1, width)
        physical = table[:, 1] if tags else np.zeros(count, int)
        yield kind, np.arange(done, done + count), physical, table[:, 1 + tags :]
        done += count


def _version_4(sections: dict[str, Cursor], text: bool, size: int) -> CellMesh:
    long = f"<u{size}"
    tags = _entities(sections["Entities"], text, long) if "Entities" in sections else {}
    cursor = sections["Nodes"]
    n_blocks, total, *_ = cursor.numbers(long, 4, text=text, what="nodes").tolist()
    ids, points = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for _ in range(n_blocks):
        dimension, _, parametric = cursor.numbers("<i4", 3, text=text, what="nodes").tolist()
        (count,) = cursor.numbers(long, 1, text=text, what="nodes").tolist()
        ids.append(cursor.numbers(long, count, text=text, what="nodes").astype(np.int64))
        width = 3 + (dimension if parametric else 0)
        rows = cursor.numbers("<f8", count * width, text=text, what="nodes").reshape(-1, width)
        points.append(rows[:, :3])
    _finished(cursor, "Nodes")
    nodes, table = np.concatenate(ids), np.concatenate(points)
    if len(nodes) != total:
        raise MeshError(f"$Nodes says {total} nodes, holds {len(nodes)}: damaged")
    cursor = sections["Elements"]
    n_blocks, total, *_ = cursor.numbers(long, 4, text=text, what="elements").tolist()
    blocks, labels, done = [], defaultdict(list), 0
    for _ in range(n_blocks):
        dimension, entity, kind = cursor.numbers("<i4", 3, text=text, what="elements").tolist()
        (count,) = cursor.numbers(long, 1, text=text, what="elements").tolist()
        name, width, _ = _type(kind)
        rows = cursor.numbers(long, count * (width + 1), text=text, what="elements")
        numbers = np.arange(done, done + count)
        blocks.append((name, rows.reshape(count, width + 1)[:, 1:].astype(np.int64), numbers))
        for label in tags.get((dimension, entity), []):
            labels[dimension, abs(label)].append(numbers)
        done += count
    _finished(cursor, "Elements")
    if done != total:
        raise MeshError(f"$Elements says {total} elements, holds {done}: damaged")
    return _mesh(nodes, table, blocks, labels, _names(sections))


def _entities(cursor: Cursor, text: bool, long: str) -> dict[tuple[int, int], list[int]]:
    """Physical numbers of each entity."""
    tags, what = {}, "entities"
    for dimension, count in enumerate(cursor.numbers(long, 4, text=text, what=what).tolist()):
        for _ in range(count):
            (tag,) = cursor.numbers("<i4", 1, text=text, what=what).tolist()
            cursor.numbers("<f8", 6 if dimension else 3, text=text, what=what)
            (many,) = cursor.numbers(long, 1, text=text, what=what).tolist()
            tags[dimension, tag] = cursor.numbers("<i4", many, text=text, what=what).tolist()
            if dimension:
                (many,) = cursor.numbers(long, 1, text=text, what=what).tolist()
                cursor.numbers("<i4", many, text=text, what=what)
    return tags


def _mesh(ids, points, blocks, labels, names) -> CellMesh:  # type: ignore[no-untyped-def]
    ids, points = distinct(ids, np.asarray(points, dtype=float))
    cells = [Cells(name, places(ids, nodes), numbers) for name, nodes, numbers in blocks]
    groups: dict[str, np.ndarray] = {}
    for (dimension, label), parts in labels.items():
        if label:
            name = names.get((dimension, label), f"physical {label}")
            groups[name] = np.unique(np.concatenate([groups.get(name, parts[0]), *parts]))
    return CellMesh(points, cells, groups, labels=ids)


def _count(cursor: Cursor) -> int:
    word = cursor.full_line()
    if not word.isdecimal():
        raise MeshError(f"{cursor.where()}: '{clean_name(word)[:24]}' is no count")
    if int(word) > len(cursor.data):
        raise MeshError(f"{cursor.where()}: counts {word}, more than the file has bytes")
    return int(word)


def _finished(cursor: Cursor, name: str) -> None:
    if cursor.data[cursor.place :].strip():
        raise MeshError(f"${name} holds more than it counts: damaged; export or copy it again")
