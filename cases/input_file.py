"""Files that scenes name: where they are, and what they hold, so that a run can keep its own."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class InputFile:
    """A file beside a scene.

    Attributes
    ----------
    name : str
        As the scene says it, relative to the scene's own folder; empty for no file.
    path : Path
        Where it is.
    digest : str
        SHA-256 of its contents; files of equal contents are equal, whatever their names.
    """

    name: str = field(default="", compare=False)
    path: Path = field(default=Path(), compare=False)
    digest: str = ""

    def __bool__(self) -> bool:
        return bool(self.name)

    @classmethod
    def at(cls, name: str, folder: Path) -> InputFile:
        """The file of a name, relative to a folder.

        Raises
        ------
        OSError
            No such file, or none that can be read.
        """
        if not name:
            return cls()
        path = (folder / name).resolve()
        with path.open("rb") as file:
            return cls(name, path, hashlib.file_digest(file, "sha256").hexdigest())


@dataclass(frozen=True)
class LocatedName:
    """The name of a file in a scene's table, and the folder that it counts from."""

    name: str
    folder: Path


def input_files(scene: Any) -> Iterator[tuple[str, str, InputFile]]:
    """Section, key and file of each file that a scene names."""
    for section in fields(scene):
        part = getattr(scene, section.name)
        for key in fields(part) if is_dataclass(part) else ():
            value = getattr(part, key.name)
            if isinstance(value, InputFile) and value:
                yield section.name, key.name, value


def with_own_files(scene: Any, folder: Path) -> Any:
    """The scene with its files copied into a folder, by names of their own there.

    Raises
    ------
    OSError
        A file that cannot be copied.
    """
    for section, key, file in list(input_files(scene)):
        name = f"{section}_{key}{file.path.suffix.lower()}"
        if file.path != (folder / name).resolve():
            (folder / name).write_bytes(file.path.read_bytes())
        part = replace(getattr(scene, section), **{key: InputFile.at(name, folder)})
        scene = replace(scene, **{section: part})
    return scene
