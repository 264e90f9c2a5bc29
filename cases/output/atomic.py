"""Files replaced as a whole: a reader, or a run killed at any moment, sees old or new, never half.

Growing text files are only appended to by complete lines; what lies beyond the length that the
checkpoint knows is cut off when a run goes on.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

SUFFIX = ".part"


class RecordError(ValueError):
    """A file of a run folder that cannot be used, and what to do about it."""


@contextmanager
def replacing(path: Path, mode: str = "w") -> Iterator[IO]:
    """Open a file beside ``path`` that takes its place when the block ends without error."""
    part = path.with_name(path.name + SUFFIX)
    with open(part, mode, encoding=None if "b" in mode else "utf-8") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def on_disk(path: Path) -> None:
    """Return when a file is on the disk, not in the system's memory alone."""
    with open(path, "rb+") as file:
        os.fsync(file.fileno())


def digest(path: Path, size: int) -> str:
    """Hash of the first ``size`` bytes of a file; empty if it is shorter."""
    found, left = hashlib.sha256(), size
    with open(path, "rb") as file:
        while left and (block := file.read(min(left, 1 << 20))):
            found.update(block)
            left -= len(block)
    return "" if left else found.hexdigest()


def remove_parts(folder: Path) -> None:
    """Delete what a killed run left unfinished."""
    for part in folder.rglob(f"*{SUFFIX}"):
        part.unlink()
