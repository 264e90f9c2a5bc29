"""A place in a file that holds counted numbers, as text or binary: never reads past the end."""

from __future__ import annotations

import re
from itertools import islice
from typing import Any

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError

_WORD = re.compile(rb"\S+")
# words of a text that are taken at a time, as each is an object first
_CHUNK = 1 << 18


class Cursor:
    """Reads lines, words and arrays one after the other."""

    def __init__(self, data: bytes, place: int = 0) -> None:
        self.data, self.place = data, place

    @property
    def at_end(self) -> bool:
        """Whether everything was read."""
        return self.place >= len(self.data)

    def where(self) -> str:
        """The place in words."""
        return f"line {_line(self.data, self.place)}"

    def line(self) -> str:
        """The rest of this line, without blanks at its ends."""
        stop = self.data.find(b"\n", self.place)
        stop = len(self.data) if stop < 0 else stop
        text, self.place = self.data[self.place : stop], stop + 1
        return text.decode("latin-1").strip()

    def full_line(self) -> str:
        """The next line that is not blank; "" at the end."""
        while not self.at_end:
            text = self.line()
            if text:
                return text
        return ""

    def numbers(self, dtype: Any, count: int, *, text: bool, what: str) -> np.ndarray:
        """The next `count` numbers: words of a text, or `dtype` as it stands."""
        count, dtype = int(count), np.dtype(dtype)
        room = len(self.data) - self.place
        if count < 0 or (count if text else count * dtype.itemsize) > max(room, 0):
            raise self._ended(what, count)
        if not text:
            start, self.place = self.place, self.place + count * dtype.itemsize
            native = dtype.newbyteorder("=")
            return np.frombuffer(self.data, dtype, count, start).astype(native)
        start, words = self.place, _WORD.finditer(self.data, self.place)
        kind, parts = dtype.newbyteorder("="), []
        for first in range(0, count, _CHUNK):
            found = list(islice(words, min(_CHUNK, count - first)))
            if len(found) < min(_CHUNK, count - first):
                raise self._ended(what, count)
            try:
                parts.append(np.array([word.group() for word in found]).astype(kind))
            except (ValueError, OverflowError):
                raise MeshError(
                    f"{what} after line {_line(self.data, start)}: not all are numbers"
                ) from None
            self.place = found[-1].end()
        return np.concatenate(parts) if parts else np.empty(0, kind)

    def _ended(self, what: str, count: int) -> MeshError:
        return MeshError(
            f"ends at byte {len(self.data)}, before all of {count} numbers ({what}): cut short or "
            "damaged; export or copy it again"
        )


def integers(values: np.ndarray, what: str) -> np.ndarray:
    """Whole numbers of a table that was read as floats."""
    if not np.all(np.abs(values) < 2**53) or np.any(values != np.round(values)):
        raise MeshError(f"{what}: a number that should be whole is not")
    return values.astype(np.int64)


def _line(data: bytes, place: int) -> int:
    """Number of the line at a place."""
    return data.count(b"\n", 0, place) + 1
