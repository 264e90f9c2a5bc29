"""Text of mesh files: its encoding, its numbers and its fields, with the line in every refusal."""

from __future__ import annotations

import re

from ..facet_mesh import MeshError

# 1.5-3 and 1.5+3 are 1.5e-3 and 1.5e3 in decks that Fortran programs write, D an exponent too.
MOST_NUMBER = 10**10
_BARE = re.compile(r"(?<=[\d.])([+-]\d+)$")


def text_of(data: bytes) -> str:
    """Text of a file: UTF-8, UTF-16 with its mark, or Latin-1."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    if b"\0" in data:
        place = data.index(b"\0")
        raise MeshError(f"binary data at byte {place}, text is expected; export as text")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def real(word: str, line: int) -> float:
    """A number as decks write it."""
    text = word.strip()
    try:
        return float(text)
    except ValueError:
        try:
            return float(_BARE.sub(r"e\1", text.lower().replace("d", "e")))
        except ValueError:
            raise MeshError(f"line {line}: '{_short(text)}' is no number") from None


def whole(word: str, line: int) -> int:
    """A whole number."""
    try:
        number = int(word)
    except ValueError:
        raise MeshError(f"line {line}: '{_short(word)}' is no whole number") from None
    if abs(number) >= MOST_NUMBER:
        raise MeshError(f"line {line}: {_short(word)} is too large for a number; renumber the file")
    return number


def _short(word: str) -> str:
    """Head of a word, without what would break the line of an answer."""
    return "".join(c if c.isprintable() else "?" for c in word.strip()[:24])


def clean_name(name: str) -> str:
    """A group's name in one printable line."""
    text = "".join(c if c.isprintable() else " " for c in name).strip().strip("\"'").strip()
    return " ".join(text.split())[:80]


def columns(line: str, widths: tuple[int, ...]) -> list[str]:
    """Fields of fixed widths, as many as the line has."""
    fields, start = [], 0
    for width in widths:
        if start >= len(line):
            break
        fields.append(line[start : start + width].strip())
        start += width
    return fields


def cut_short(data: bytes, ending: str = "") -> list[str]:
    """Note on a text that stops without a line end: what follows may be missing."""
    if data[-1:] in b"\n\r" and not ending:
        return []
    what = ending or "its last line has no end"
    return [f"{what}: nothing tells whether the file is whole"]
