"""Text of scenes: shipped ones by name, others by path; its encoding, its TOML, its overflows."""

from __future__ import annotations

import difflib
import tomllib
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from .limits import SHOWN, shown
from .sections import AnyScene, SceneError, unusual

# endings of mesh files, which are given by mistake for scenes that name them
MESHES = (".stl", ".obj", ".ply", ".off", ".msh", ".vtk", ".vtu", ".vtp", ".inp", ".bdf", ".nas",
          ".dat", ".k", ".key", ".dyn")  # fmt: skip


def folder() -> Any:
    """Where the shipped scenes are."""
    return files("cases") / "scenes"


def names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(entry.name[:-5] for entry in folder().iterdir() if entry.name.endswith(".toml"))


def home_of(scene: str | Path) -> Path:
    """The folder that names of files in a scene count from."""
    shipped = str(scene) in names() if isinstance(scene, str) else False
    return Path(str(folder())) if shipped else Path(scene).resolve().parent


def text_of(scene: str | Path) -> str:
    """Text of a shipped scene or of a file."""
    path = Path(scene)
    if path.suffix.lower() in MESHES:
        raise SceneError(
            [
                f"{scene}: a mesh is no scene; name it in one: a TOML file beside it with "
                f'[geometry] kind = "mesh", file = "{path.name}" and its inlet'
            ]
        )
    resource = folder() / f"{scene}.toml"
    looks_like_path = path.suffix == ".toml" or len(path.parts) > 1 or isinstance(scene, Path)
    try:
        if not looks_like_path and resource.is_file():
            return resource.read_text(encoding="utf-8")
        if looks_like_path or path.is_file():
            return _decoded(path.read_bytes())
    except OSError as error:
        raise SceneError([f"{scene}: cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError as error:
        reason = f"is not UTF-8 text: {error.reason}; save it as UTF-8"
        raise SceneError([f"{scene}: {reason}"]) from None
    except ValueError as error:  # no path at all: a null character
        raise SceneError([f"{shown(str(scene))}: cannot be read: {error}"]) from None
    raise SceneError([f"{scene}: no such scene or file{nearest(str(scene), names())}"])


def _decoded(data: bytes) -> str:
    """The text of a file, without its byte order mark.

    Raises
    ------
    UnicodeDecodeError
        Other encodings than UTF-8.
    """
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        raise UnicodeDecodeError("utf-8", data, 0, 2, "it begins like UTF-16")
    # TOML knows two ends of a line: universal newlines would let a lone carriage return pass
    return data.decode("utf-8-sig")


def parse(origin: str, text: str) -> dict[str, Any]:
    """The tables of a scene's text."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError([f"{origin}: unreadable TOML: {error}"]) from None
    except ValueError:
        message = f"{origin}: a number has too many digits; look at {_longest(text)}"
        raise SceneError([message]) from None


def nearest(name: str, valid: Sequence[str]) -> str:
    """Ending of a message: the nearest valid name, or all of them."""
    close = difflib.get_close_matches(name[:SHOWN], valid, n=1)
    return f", did you mean {close[0]!r}?" if close else f"; valid: {', '.join(valid)}"


@contextmanager
def last_resort(name: str, of: str | AnyScene) -> Iterator[None]:
    """Name the scene and its likely key where all limits have missed what overflows.

    Parameters
    ----------
    name : str
        Of the scene.
    of : str or scene
        Its text, or the scene itself once it is read.

    Raises
    ------
    SceneError
        Instead of a recursion, an overflow or exhausted memory.
    """
    try:
        yield
    except (RecursionError, OverflowError, MemoryError) as error:
        nested = isinstance(error, RecursionError)
        what = "is nested too deeply" if nested else str(error) or "needs too much memory"
        where = _longest(of) if isinstance(of, str) else unusual(of)
        raise SceneError([f"{name}: {what}; look at {where}"]) from None


def _longest(text: str) -> str:
    """The key of the longest line, where too deep or too long a value most likely stands."""
    line = max(text.splitlines(), key=len, default="")
    return shown(line.split("=")[0].strip())
