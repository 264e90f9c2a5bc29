"""Files replaced as a whole: a reader, or a run killed at any moment, sees old or new, never half.

Growing text files are only appended to by complete lines; ``keep_lines`` cuts them back.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

SUFFIX = ".part"


@contextmanager
def replacing(path: Path, mode: str = "w") -> Iterator[IO]:
    """Open a file beside ``path`` that takes its place when the block ends without error."""
    part = path.with_name(path.name + SUFFIX)
    with open(part, mode, encoding=None if "b" in mode else "utf-8") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def keep_lines(path: Path, keep: Callable[[str], bool]) -> None:
    """Keep the header and those complete lines of a text file that ``keep`` accepts."""
    if not path.exists():
        return
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    complete = [line for line in lines if line.endswith("\n")]
    with replacing(path) as file:
        file.writelines(complete[:1] + [line for line in complete[1:] if keep(line)])


def remove_parts(folder: Path) -> None:
    """Delete what a killed run left unfinished."""
    for part in folder.rglob(f"*{SUFFIX}"):
        part.unlink()
