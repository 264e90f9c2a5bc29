"""Abaqus decks (.inp): shells and membranes (S3, S4, STRI65, M3D3, M3D4, ...) with element sets.

Nodes and elements of each *PART are numbered on their own. What moves or makes nodes is refused.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import CellCollector, CellMesh, Cells, distinct, places
from cases.geometry.meshes.formats.text import (
    MOST_NUMBER,
    clean_name,
    cut_short,
    real,
    text_of,
    whole,
)

# names of elements, by what they begin with: kind and nodes
_TYPES = (
    (r"(STRI65|(M3D|SFM3D|DS|CPS|CPE)6)", "triangle6", 6),
    (r"(S3|STRI3|(M3D|SFM3D|R3D|F3D|DS|CPS|CPE)3)", "triangle", 3),
    (r"(S8R|(M3D|SFM3D|DS|CPS|CPE)8)", "quad8", 8),
    (r"(S9R5|(M3D)9)", "quad9", 9),
    (r"(S4|(M3D|SFM3D|R3D|F3D|DS|CPS|CPE)4)", "quad", 4),
    (r"C3D4", "tetra", 4),
    (r"C3D10", "tetra", 10),
    (r"C3D20", "hexahedron", 20),
    (r"(C3D8|SC8R)", "hexahedron", 8),
    (r"C3D15", "wedge", 15),
    (r"(C3D6|SC6R)", "wedge", 6),
    (r"C3D5", "pyramid", 5),
    (r"(B[23]1|B33|B23|T[23]D2|PIPE[23]1|R[AB]2D2|RB3D2|CONN)", "line", 2),
    (r"(B[23]2|T[23]D3|PIPE[23]2)", "line", 3),
    (r"(MASS|ROTARYI)", "vertex", 1),
)
_REFUSED = {
    "INCLUDE": "put its text into this file",
    "NGEN": "export the nodes themselves",
    "NFILL": "export the nodes themselves",
    "NCOPY": "export the nodes themselves",
    "ELGEN": "export the elements themselves",
    "ELCOPY": "export the elements themselves",
    "SYSTEM": "export global coordinates",
    "TRANSFORM": "export global coordinates",
}


@dataclass
class _Deck:
    """What was read so far; numbers of nodes and elements are those of a part."""

    part: str = ""
    ids: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    parts: dict[str, int] = field(default_factory=dict)  # name: place of its numbers
    cells: CellCollector = field(default_factory=CellCollector)
    elements: dict[tuple[str, int], int] = field(default_factory=dict)
    sets: dict[tuple[str, str], list[int]] = field(default_factory=lambda: defaultdict(list))
    names: dict[tuple[str, str], str] = field(default_factory=dict)
    instances: dict[str, str] = field(default_factory=dict)


# numbers of nodes of one part stay below this; the next part's begin above
_SPAN = MOST_NUMBER


def read(data: bytes) -> CellMesh:
    """Nodes, elements, sets of elements as groups; parts too where there are several."""
    deck = _Deck()
    for line, keyword, options, rows in _blocks(text_of(data)):
        if keyword in _REFUSED:
            raise MeshError(f"line {line}: *{keyword} is not read; {_REFUSED[keyword]}")
        reader = _READERS.get(keyword)
        if reader:
            reader(deck, line, options, rows)
    ids, points = distinct(np.array(deck.ids, np.int64), np.array(deck.points).reshape(-1, 3))
    cells = [
        block if block.kind.startswith("element ") else _placed(block, ids)
        for block in deck.cells.cells()
    ]
    groups: dict[str, list[int]] = defaultdict(list)
    for key, numbers in deck.sets.items():
        groups[deck.names[key]] += numbers
    if len(deck.parts) > 1:
        for (part, _), number in deck.elements.items():
            groups[part] += [number]
    found = {name: np.unique(np.array(own, np.int64)) for name, own in groups.items()}
    return CellMesh(points, cells, found, ids % _SPAN, notes=cut_short(data))


def _placed(block: Cells, ids: np.ndarray) -> Cells:
    try:
        return Cells(block.kind, places(ids, block.nodes), block.numbers)
    except MeshError:
        missing = block.nodes[~np.isin(block.nodes, ids)][0] % _SPAN
        raise MeshError(f"an element names node {missing}, which the file has not") from None


def _blocks(text: str) -> Iterator[tuple[int, str, dict[str, str], list[tuple[int, list[str]]]]]:
    """Line, keyword, its options (upper case) and the fields of its data lines."""
    head: tuple[int, str, dict[str, str]] | None = None
    rows: list[tuple[int, list[str]]] = []
    joined: list[str] = []
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if line.startswith("*") or joined:
            joined.append(line)
            if line.endswith(","):
                continue
            line, joined = "".join(joined), []
            if head:
                yield *head, rows
            keyword, *options = line[1:].split(",")
            pairs = (option.partition("=") for option in options)
            found = {key.strip().upper(): clean_name(value) for key, _, value in pairs}
            head, rows = (number, keyword.strip().upper(), found), []
        elif head:
            rows.append((number, [word.strip() for word in line.split(",")]))
        else:
            raise MeshError(f"line {number}: a keyword (*HEADING, *NODE, ...) is expected first")
    if head:
        yield *head, rows


def _part(deck: _Deck, line: int, options: dict, rows: list) -> None:
    deck.part = options.get("NAME", f"part {len(deck.parts) + 1}")


def _end_part(deck: _Deck, line: int, options: dict, rows: list) -> None:
    deck.part = ""


def _instance(deck: _Deck, line: int, options: dict, rows: list) -> None:
    name, part = options.get("NAME", ""), options.get("PART", "")
    if rows and all(re.fullmatch(r"[-+\d.eE]*", word) for word in rows[0][1]):
        moves = [real(word, rows[0][0]) for word in rows[0][1] if word]
        if any(moves) or len(rows) > 1:
            raise MeshError(f"line {line}: instance '{name}' is moved; export the assembly as mesh")
    if part in deck.instances.values():
        raise MeshError(f"line {line}: part '{part}' has two instances; export them as mesh")
    deck.instances[name] = part
    deck.part = part or name


def _nodes(deck: _Deck, line: int, options: dict, rows: list) -> None:
    base = _SPAN * deck.parts.setdefault(deck.part, len(deck.parts))
    for number, words in rows:
        if len(words) < 3:
            raise MeshError(f"line {number}: a node of {len(words) - 1} coordinates")
        place = [real(word, number) if word else 0.0 for word in (*words[1:4], "0")[:3]]
        deck.ids.append(base + whole(words[0], number))
        deck.points.append(place)


def _elements(deck: _Deck, line: int, options: dict, rows: list) -> None:
    name = options.get("TYPE", "").upper()
    kind, count = f"element {name or '?'}", 0
    for pattern, known, width in _TYPES:
        if re.match(rf"{pattern}(?!\d)", name):
            kind, count = known, width
            break
    base = _SPAN * deck.parts.setdefault(deck.part, len(deck.parts))
    words: list[str] = []
    for number, row in rows:
        words += [word for word in row if word]
        if len(words) <= count and count:
            continue
        if count and len(words) != count + 1:
            raise MeshError(f"line {number}: {len(words) - 1} nodes in an element {name}")
        nodes = [base + whole(word, number) for word in words[1:]] if count else [0]
        cell = deck.cells.add(kind, nodes)
        deck.elements[deck.part, whole(words[0], number)] = cell
        if "ELSET" in options:
            _member(deck, options["ELSET"]).append(cell)
        words = []
    if words:
        raise MeshError(f"line {rows[-1][0]}: the last element {name} ends too soon: cut short")


def _member(deck: _Deck, name: str) -> list[int]:
    """Numbers in a set; names do not mind their case."""
    key = deck.part, name.upper()
    deck.names.setdefault(key, name)
    return deck.sets[key]


def _set(deck: _Deck, line: int, options: dict, rows: list) -> None:
    part = deck.instances.get(options.get("INSTANCE", ""), deck.part)
    part = part if part in deck.parts or len(deck.parts) != 1 else next(iter(deck.parts))
    own = _member(deck, options.get("ELSET", f"set of line {line}"))
    for number, row in rows:
        words = [word for word in row if word]
        if "GENERATE" in options:
            first, last, step = [whole(word, number) for word in (*words, "1")[:3]]
            wanted: Sequence[int] = range(first, last + 1, max(step, 1))
            if len(wanted) > len(deck.elements):
                wanted = [n for place, n in deck.elements if place == part and n in wanted]
            found = (deck.elements.get((part, n)) for n in wanted)
            own += [cell for cell in found if cell is not None]
            continue
        for word in words:
            own += _named(deck, part, word, number)


def _named(deck: _Deck, part: str, word: str, line: int) -> list[int]:
    """Cells of one element or one set."""
    if word.isdecimal():
        if (part, int(word)) not in deck.elements:
            raise MeshError(f"line {line}: a set names element {word}, which the file has not")
        return [deck.elements[part, int(word)]]
    key = part, clean_name(word.rpartition(".")[2]).upper()
    if key not in deck.sets:
        raise MeshError(f"line {line}: a set names set '{clean_name(word)[:40]}', unknown so far")
    return deck.sets[key]


_READERS = {
    "PART": _part,
    "END PART": _end_part,
    "INSTANCE": _instance,
    "END INSTANCE": _end_part,
    "NODE": _nodes,
    "ELEMENT": _elements,
    "ELSET": _set,
}
