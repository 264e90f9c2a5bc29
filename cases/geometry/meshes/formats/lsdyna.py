"""LS-DYNA decks (.k, .key, .dyn): shells, parts and sets as groups, the unfolded reference.

Fields of 8 and 16 columns (10 and 16 with %, 20 with +), or commas; a third node twice is a
triangle.
*AIRBAG_REFERENCE_GEOMETRY gives places of nodes in the stress-free bag.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import CellCollector, CellMesh, distinct, places
from cases.geometry.meshes.formats.text import clean_name, columns, cut_short, real, text_of, whole

_PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)


class _Columns(NamedTuple):
    """Widths of the fields of nodes, of shells and of all other cards."""

    node: tuple[int, ...]
    shell: tuple[int, ...]
    card: tuple[int, ...]


# by the mark behind a keyword: standard, I10, long
_FORMS = {
    "-": _Columns((8, 16, 16, 16), (8,) * 10, (10,) * 8),
    "%": _Columns((10, 16, 16, 16), (10,) * 10, (10,) * 8),
    "+": _Columns((20,) * 4, (20,) * 10, (20,) * 8),
}
_REFUSED = {
    "INCLUDE": "put its text into this file",
    "NODE_TRANSFORM": "export the moved nodes",
    "NODE_SCALAR": "export plain nodes",
    "AIRBAG_SHELL_REFERENCE_GEOMETRY": "give it by nodes (*AIRBAG_REFERENCE_GEOMETRY)",
    "ELEMENT_GENERATE": "export the elements themselves",
}


@dataclass
class _Deck:
    form: str = "-"
    ids: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    unfolded: dict[int, list[float]] = field(default_factory=dict)
    cells: CellCollector = field(default_factory=CellCollector)
    elements: dict[int, int] = field(default_factory=dict)
    parts: dict[int, list[int]] = field(default_factory=dict)
    titles: dict[int, str] = field(default_factory=dict)
    sets: dict[str, np.ndarray] = field(default_factory=dict)
    pending: list[tuple[str, list[int], list[tuple[int, int]]]] = field(default_factory=list)
    left: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)


def read(data: bytes) -> CellMesh:
    """Nodes, shells, groups by the titles of parts, the reference if there is one."""
    text = text_of(data)
    if not re.search(r"^\*(KEYWORD|NODE|TITLE|ELEMENT|PART)", text, re.MULTILINE | re.IGNORECASE):
        raise MeshError("not an LS-DYNA deck: no line begins with *KEYWORD or *NODE")
    deck, ended = _Deck(), False
    for line, keyword, options, rows in _blocks(text):
        if keyword == "END":
            ended = True
            break
        if keyword == "KEYWORD":
            if re.search(r"LONG\s*=\s*[YK]", options, re.IGNORECASE):
                deck.form = "+"
            elif re.search(r"I10\s*=\s*Y", options, re.IGNORECASE):
                deck.form = "%"
            continue
        for word, remedy in _REFUSED.items():
            if keyword.startswith(word):
                raise MeshError(f"line {line}: *{keyword} is not read; {remedy}")
        _take(deck, line, keyword, options, rows)
    ids, points = distinct(np.array(deck.ids, np.int64), np.array(deck.points).reshape(-1, 3))
    reference = _reference(deck, ids, points)
    notes = [*deck.notes, *(f"{n} lines of *{key} left out" for key, n in deck.left.items())]
    notes += [] if ended else cut_short(data, "no *END at its end")
    cells = deck.cells.cells(ids)
    return CellMesh(points, cells, _groups(deck), ids, reference, notes)


def _blocks(text: str) -> Iterator[tuple[int, str, str, list[tuple[int, str]]]]:
    """Line, keyword, what follows it, and its data lines."""
    head: tuple[int, str, str] | None = None
    rows: list[tuple[int, str]] = []
    for number, raw in enumerate(text.splitlines(), 1):
        if raw.startswith("$"):
            continue
        if raw.startswith("-----BEGIN PGP"):
            raise MeshError(f"line {number}: encrypted from here on; export a plain deck")
        if raw.startswith("*"):
            if head:
                yield *head, rows
            word, _, rest = raw[1:].strip().partition(" ")
            head, rows = (number, word.upper(), rest.strip()), []
        elif head:
            rows.append((number, raw.rstrip()))
        elif raw.strip():
            raise MeshError(f"line {number}: a keyword (*KEYWORD, *NODE, ...) is expected first")
    if head:
        yield *head, rows


def _take(deck: _Deck, line: int, keyword: str, options: str, rows: list) -> None:
    """One keyword with its lines."""
    mark = keyword[-1:] if keyword[-1:] in ("%", "+", "-") else options[:1]
    keyword = keyword.rstrip("%+-")
    form = _FORMS.get(mark, _FORMS[deck.form])
    full = [(number, row) for number, row in rows if row.strip()]
    if keyword == "NODE":
        for number, row in full:
            label, place = _place(row, number, form.node)
            deck.ids.append(label)
            deck.points.append(place)
    elif keyword.startswith("ELEMENT_SHELL"):
        _shells(deck, line, keyword, full, form)
    elif keyword == "PART" or keyword.startswith("PART_"):
        while rows and not rows[-1][1].strip():
            rows = rows[:-1]
        # options bring cards of their own behind each part's: one title then
        for (_, title), (number, card) in list(zip(rows[::2], rows[1::2], strict=False))[
            : None if keyword == "PART" else 1
        ]:
            words = _split(card, form.card)
            deck.titles[whole(words[0] if words else "", number)] = clean_name(title)
    elif keyword.startswith("SET_SHELL"):
        _set(deck, keyword, rows, form)
    elif keyword.startswith("AIRBAG_REFERENCE_GEOMETRY"):
        _unfolded(deck, keyword, full, form)
    elif keyword.startswith("ELEMENT_"):
        deck.left[keyword] += len(full)


def _split(row: str, widths: tuple[int, ...]) -> list[str]:
    """Fields by commas, by columns, or by blanks where columns cut through them."""
    if "," in row:
        return [word.strip() for word in row.split(",")]
    words = columns(row, widths)
    return row.split() if not words[0] or any(" " in word for word in words) else words


def _place(row: str, line: int, widths: tuple[int, ...]) -> tuple[int, list[float]]:
    """Number and place of a node."""
    words, loose = _split(row, widths), row.split()
    # narrower or wider than the columns; numbers that touch have no blanks to split at
    if words[:4] != loose[:4] and len(loose) >= 4 and all(map(_PLAIN.fullmatch, loose[:4])):
        words = loose
    if len(words) < 2:
        raise MeshError(f"line {line}: a node with {len(words) - 1} coordinates: cut short?")
    # trailing blanks are zeros
    place = [real(word, line) if word else 0.0 for word in (*words[1:4], "", "")[:3]]
    return whole(words[0], line), place


def _shells(deck: _Deck, line: int, keyword: str, rows: list, form: _Columns) -> None:
    """Shells with the cards that their options bring."""
    options = set(keyword.split("_")[2:])
    if options - {"THICKNESS", "BETA", "MCID", "OFFSET", "TITLE"}:
        raise MeshError(f"line {line}: *{keyword} is not read; export plain *ELEMENT_SHELL")
    extra = bool(options & {"THICKNESS", "BETA", "MCID"}) + ("OFFSET" in options)
    i, second = 0, 0
    while i < len(rows):
        number, row = rows[i]
        words = _split(row, form.shell)
        if len(words) < 5:
            raise MeshError(f"line {number}: a shell with {max(len(words) - 2, 0)} nodes")
        numbers = [whole(word, number) if word else 0 for word in words[:10]]
        label, part, *nodes = numbers
        more = any(nodes[4:])
        second += more
        nodes = nodes[:3] if len(nodes) < 4 or nodes[3] in (0, nodes[2]) else nodes[:4]
        deck.elements[label] = deck.cells.add("triangle" if len(nodes) == 3 else "quad", nodes)
        deck.parts.setdefault(part, []).append(deck.elements[label])
        # thicknesses at middle nodes take a card more
        i += 1 + extra + (more and "THICKNESS" in options)
    if i > len(rows):
        raise MeshError(f"line {rows[-1][0]}: the card behind the last shell is missing: cut short")
    if second:
        deck.notes.append(f"middle nodes of {second} shells left out")


def _set(deck: _Deck, keyword: str, rows: list, form: _Columns) -> None:
    """A set of shells, by list or ranges."""
    title = ""
    if "TITLE" in keyword and rows:
        title, rows = clean_name(rows[0][1]), rows[1:]
    rows = [(number, row) for number, row in rows if row.strip()]
    if not rows or "GENERAL" in keyword or "COLLECT" in keyword:
        deck.left[keyword] += len(rows)
        return
    name = title or f"set {_split(rows[0][1], form.card)[0]}"
    wanted = [
        whole(word, number)
        for number, row in rows[1:]
        for word in _split(row, form.card)
        if word and word != "0"
    ]
    ranges = list(zip(wanted[::2], wanted[1::2], strict=False)) if "GENERATE" in keyword else []
    deck.pending.append((name, [] if ranges else wanted, ranges))


def _unfolded(deck: _Deck, keyword: str, rows: list, form: _Columns) -> None:
    """Places of nodes in the unfolded bag, behind the cards of the options."""
    if "_ID" in keyword and rows:
        number, row = rows[0]
        scales = _split(row, form.card)[1:4]
        if any(real(word, number) not in (0.0, 1.0) for word in scales if word):
            raise MeshError(f"line {number}: a scaled reference geometry; export it unscaled")
        rows = rows[1:]
    rows = rows[1:] if "BIRTH" in keyword else rows
    for number, row in rows:
        label, place = _place(row, number, form.node)
        deck.unfolded[label] = place


def _reference(deck: _Deck, ids: np.ndarray, points: np.ndarray) -> np.ndarray | None:
    if not deck.unfolded:
        return None
    reference = points.copy()
    labels = np.array(list(deck.unfolded), np.int64)
    known = np.isin(labels, ids)
    reference[places(ids, labels[known])] = np.array(list(deck.unfolded.values()))[known]
    deck.notes.append(f"reference geometry of {np.sum(known)} of {len(ids)} nodes")
    return reference


def _groups(deck: _Deck) -> dict[str, np.ndarray]:
    """Parts by their titles, sets by theirs."""
    groups: dict[str, np.ndarray] = {}
    for part, own in deck.parts.items():
        name = deck.titles.get(part) or f"part {part}"
        groups[f"{name} ({part})" if name in groups else name] = np.array(own)
    for name, labels, ranges in deck.pending:
        found = [deck.elements[label] for label in labels if label in deck.elements]
        for a, b in ranges:
            wanted: Sequence[int] = range(a, b + 1)
            if len(wanted) > len(deck.elements):
                wanted = [label for label in deck.elements if label in wanted]
            found += [deck.elements[label] for label in wanted if label in deck.elements]
        groups[f"{name} (set)" if name in groups else name] = np.unique(np.array(found, np.int64))
    return groups
