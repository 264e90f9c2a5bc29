"""From a mesh file to triangles: which reader, what no file may do, and errors of one line."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from .facet_mesh import FacetMesh, MeshError
from .faceting import faceted

MOST_BYTES = 1 << 28
# ending: name of the format, module of its reader
FORMATS = {
    ".stl": ("STL", "stl"),
    ".obj": ("OBJ", "obj"),
    ".ply": ("PLY", "ply"),
    ".off": ("OFF", "off"),
    ".msh": ("Gmsh", "gmsh"),
    ".vtk": ("VTK", "vtk_legacy"),
    ".vtu": ("VTK XML", "vtk_xml"),
    ".vtp": ("VTK XML", "vtk_xml"),
    ".inp": ("Abaqus", "abaqus"),
    ".bdf": ("Nastran", "nastran"),
    ".nas": ("Nastran", "nastran"),
    ".dat": ("Nastran", "nastran"),
    ".k": ("LS-DYNA", "lsdyna"),
    ".key": ("LS-DYNA", "lsdyna"),
    ".dyn": ("LS-DYNA", "lsdyna"),
}
# how files begin that are of no mesh format, whatever their names say
_OTHERS = {
    b"<!doctype html": "a web page",
    b"<html": "a web page",
    b"pk\x03\x04": "a zip archive; unpack it",
    b"\x1f\x8b": "a gzip archive; unpack it",
    b"\x93numpy": "an array of numpy",
    b"%pdf": "a PDF document",
    b"version https://git-lfs": "a pointer of git-lfs; fetch the file itself",
}


def read_facets(path: str | os.PathLike[str]) -> FacetMesh:
    """Triangles of a mesh file as they stand in it, with its groups.

    Quads and polygons are split, solids give their boundary, all else is named in the notes.

    Parameters
    ----------
    path : path
        A file of STL, OBJ, PLY, OFF, Gmsh, VTK, Abaqus, Nastran or LS-DYNA, by its ending.

    Returns
    -------
    FacetMesh
        Unwelded and not oriented: see `repaired`.

    Raises
    ------
    MeshError
        One line with the file, the place and a remedy; no other error comes from a file.
    """
    path = Path(path)
    name, reader = _format(path)
    data = _bytes(path)
    try:
        # deep or huge files fail in many ways, and none may pass as anything but a word on the file
        mesh = faceted(import_module(f".formats.{reader}", __package__).read(data))
    except MeshError as error:
        # words of a damaged file may hold anything
        told = "".join(c if c.isprintable() else "?" for c in str(error))
        remedy = "" if ";" in told else "; mend it there or export it again"
        raise MeshError(f"{path.name}: {told}{remedy}") from None
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise MeshError(
            f"{path.name}: cannot be read as {name} ({what}); save it again in a mesh tool"
        ) from error
    parts = f", {len(mesh.groups)} groups" if mesh.groups else ""
    head = f"{path.name}: {name}, {len(mesh.triangles)} triangles, {len(mesh.points)} points{parts}"
    return replace(mesh, notes=(head, *mesh.notes))


@contextmanager
def of_file(path: str | os.PathLike[str]) -> Iterator[None]:
    """Let errors inside begin with the name of the file that they are about, once."""
    name = Path(path).name
    try:
        yield
    except MeshError as error:
        told = str(error)
        raise MeshError(told if told.startswith(f"{name}: ") else f"{name}: {told}") from error


def _format(path: Path) -> tuple[str, str]:
    ending = path.suffix.lower()
    if ending not in FORMATS:
        known = " ".join(FORMATS)
        raise MeshError(f"{path.name}: no reader for '{ending}'; save it as one of {known}")
    return FORMATS[ending]


def _bytes(path: Path) -> bytes:
    """What the file holds, unless it cannot be a mesh."""
    if path.is_dir():
        raise MeshError(f"{path.name}: a folder; name the file in it")
    if not path.is_file():
        raise MeshError(
            f"{path.name}: no such file in {path.parent}; paths are relative to the scene"
        )
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise MeshError(
                f"{path.name}: {size / 2**20:.0f} MiB, {MOST_BYTES >> 20} at most; decimate it in "
                "a mesh tool, or save it as binary"
            )
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path.name}: {error.strerror or error}") from None
    if not data.strip(b"\0 \t\r\n"):
        raise MeshError(f"{path.name}: empty; export it again")
    head = data[:200].lstrip().lower()
    for start, what in _OTHERS.items():
        if head.startswith(start):
            raise MeshError(f"{path.name}: no mesh but {what}")
    return data
