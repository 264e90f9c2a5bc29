"""Nastran bulk data (.bdf, .nas, .dat): shells with their properties as groups.

Fields of 8 or 16 columns, or commas. Names of properties stand in comments of the usual programs.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

import numpy as np

from ..facet_mesh import MeshError
from .cells import CellCollector, CellMesh, distinct
from .text import clean_name, columns, cut_short, real, text_of, whole

# card: kind, nodes
_SHELLS = {
    "CTRIA3": ("triangle", 3), "CTRIAR": ("triangle", 3), "CTRIA6": ("triangle6", 6),
    "CQUAD4": ("quad", 4), "CQUADR": ("quad", 4), "CSHEAR": ("quad", 4), "CQUAD8": ("quad8", 8),
    "CTETRA": ("tetra", 4), "CPYRAM": ("pyramid", 5), "CPENTA": ("wedge", 6),
    "CHEXA": ("hexahedron", 8),
}  # fmt: skip
_OTHERS = {"CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "PLOTEL", "CBUSH", "CELAS1", "CELAS2"}
_OTHERS |= {"RBE2", "RBE3", "CONM2", "CGAP", "CMASS1", "CMASS2"}
_FRAMES = re.compile(r"CORD\d[RCS]$")
# HyperMesh (its components first, as properties overrule them), Femap, ANSA, NX: number and name
_NAMES = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        r'\$\s*HMNAME\s+COMP\s+(?P<id>\d+)\s*"(?P<name>[^"\n]+)"\s*(?!\d+\s*")',
        r'\$\s*HMNAME\s+COMP\s+\d+\s*"(?P<name>[^"\n]+)"\s*(?P<id>\d+)\s*"',
        r'\$\s*HMNAME\s+PROP\s+(?P<id>\d+)\s*"(?P<name>[^"\n]+)"',
        r"\$\s*Femap.*Property\s+(?P<id>\d+)\s*:\s*(?P<name>.+)",
        r"\$\s*ANSA_NAME(?:_COMMENT)?;(?P<id>\d+);P\w+;\s*(?P<name>[^;~\s][^;\n]*)",
        r"\$\s*ANSA_NAME;(?P<id>\d+);P\w+;~?\s*\n\$\s*(?P<name>.+)",
        r"\$\*\s*Property\s*:\s*(?P<id>\d+)\s+name\s*:\s*(?P<name>.+)",
    )
)
# Patran, NX: the name stands before the property's card
_BEFORE = re.compile(
    r"\$\*?\s*(?:Elements and Element Properties for region|Property(?: Name)?)\s*:\s*(?P<name>.+)",
    re.IGNORECASE,
)


def read(data: bytes) -> CellMesh:
    """Grid points and shells; "property 7" where it has no name."""
    text = text_of(data)
    names = _names(text)
    ids, points, left = list[int](), list[list[float]](), Counter[str]()
    cells = CellCollector()
    ended = False
    for line, card, fields in _cards(text):
        if card == "ENDDATA":
            ended = True
            break
        if card == "GRID":
            if fields[1:2] not in ([], [""], ["0"]):
                raise MeshError(f"line {line}: a point in system {fields[1]}; export basic ones")
            place = [real(word, line) if word else 0.0 for word in (*fields[2:5], "", "", "")[:3]]
            ids.append(whole(fields[0], line))
            points.append(place)
        elif card in _SHELLS:
            _shell(cells, line, card, fields, names)
        elif card in _OTHERS:
            left[card] += 1
        elif card == "GRDSET" and fields[1:2] not in ([], [""], ["0"]):
            raise MeshError(f"line {line}: GRDSET gives a system to all points; export basic ones")
        elif card == "INCLUDE" or card.startswith("="):
            raise MeshError(f"line {line}: {card[:8]} is not read; export one file of plain cards")
    numbers, table = distinct(np.array(ids, np.int64), np.array(points).reshape(-1, 3))
    notes = [f"{n} {card} left out" for card, n in left.items()]
    notes += [] if ended else cut_short(data, "no ENDDATA at its end")
    return CellMesh(table, cells.cells(numbers), cells.groups(), numbers, notes=notes)


def _shell(cells: CellCollector, line: int, card: str, fields: list[str], names: dict) -> None:
    kind, count = _SHELLS[card]
    if len(fields) < count + 2:
        raise MeshError(f"line {line}: {card} with {max(len(fields) - 2, 0)} of {count} points")
    nodes = fields[2 : count + 2]
    if kind in ("triangle6", "quad8") and not all(nodes):
        raise MeshError(f"line {line}: {card} without all of its middle points; export order 1")
    label = whole(fields[1] or fields[0], line)
    group = names.get(label, f"property {label}")
    cells.add(kind, [whole(word, line) for word in nodes], [group])


def _cards(text: str) -> Iterator[tuple[int, str, list[str]]]:
    """Line, name and fields of each card, its continuations joined."""
    lines = list(enumerate(text.splitlines(), 1))
    begin = [i for i, (_, line) in enumerate(lines) if re.match(r"\s*BEGIN\s+BULK", line, re.I)]
    lines = lines[begin[0] + 1 :] if begin else lines
    head: tuple[int, str] | None = None
    fields: list[str] = []
    for number, raw in lines:
        line = raw.partition("$")[0].rstrip().expandtabs(8)
        if not line:
            continue
        name, found = _fields(line, number)
        if name[:1] in ("+", "*", ""):
            if head is None:
                raise MeshError(f"line {number}: continues no card")
            fields += found
            continue
        if head:
            yield *head, fields
        head, fields = (number, name.rstrip("*")), found
        if name == "ENDDATA":
            break
    if head:
        yield *head, fields


def _fields(line: str, number: int) -> tuple[str, list[str]]:
    """Name of a card's line ("", "+", "*" of a continuation) and its data fields, all of them."""
    if "," in line:
        name, *fields = (word.strip() for word in line.split(","))
        per_line = 4 if name.endswith("*") else 8
        fields = fields[:per_line]
    else:
        name = line[:8].strip().upper()
        if name.upper().startswith(("INCLUDE", "ENDDATA")):
            return name[:7], []
        wide = name.startswith("*") or name.endswith("*")
        fields = columns(line[8:], (16,) * 4 if wide else (8,) * 8)
        per_line = 4 if wide else 8
    for word in fields:
        if " " in word and name.upper().rstrip("*") in ("GRID", *_SHELLS):
            raise MeshError(f"line {number}: fields of 8 or 16 columns are expected, not '{word}'")
    return name.upper(), fields + [""] * (per_line - len(fields))


def _names(text: str) -> dict[int, str]:
    """Names of properties from comments."""
    names, pending = {}, ""
    lines = text.splitlines()
    spoken = [f"{a}\n{b}" for a, b in zip(lines, [*lines[1:], ""], strict=True) if a[:1] == "$"]
    for line in lines:
        if match := _BEFORE.match(line):
            pending = clean_name(match["name"])
        elif pending and re.match(r"P(SHELL|COMP|LPLANE|SHEAR|SOLID)", line):
            word = re.split(r"[,\s]+", line.replace("*", " "))[1:2]
            if word and word[0].isdecimal():
                names[int(word[0])] = pending
            pending = ""
    for pattern in _NAMES:
        for pair in spoken:
            if match := pattern.match(pair):
                names[int(match["id"])] = clean_name(match["name"])
    return names
