"""OFF of Geomview, text: counts, vertices, faces of any number of corners; colours left out."""

from __future__ import annotations

import re

import numpy as np

from ..facet_mesh import MeshError
from .cells import CellCollector, CellMesh, flat_kind
from .text import cut_short, real, text_of, whole

_HEAD = re.compile(r"(ST)?(C)?(N)?OFF$")


def read(data: bytes) -> CellMesh:
    """Vertices and faces in the order of the file."""
    lines = [
        (number, line.partition("#")[0].split())
        for number, line in enumerate(text_of(data).splitlines(), 1)
    ]
    lines = [(number, words) for number, words in lines if words]
    if not lines or not _HEAD.match(lines[0][1][0]):
        raise MeshError("line 1: 'OFF' is expected (4D and nD variants are not read)")
    number, words = lines[0]
    if "BINARY" in words:
        raise MeshError("line 1: binary OFF is not read; save it as text")
    rest = lines[1:]
    counts = words[1:]
    if not counts and rest:
        (number, counts), rest = rest[0], rest[1:]
    if len(counts) < 2:
        raise MeshError(f"line {number}: the numbers of vertices and faces are expected")
    n_points, n_faces = (whole(word, number) for word in counts[:2])
    if n_points < 0 or n_faces < 0 or len(rest) != n_points + n_faces:
        raise MeshError(
            f"line {number} says {n_points} vertices and {n_faces} faces, {len(rest)} lines follow:"
            " cut short or damaged; export or copy it again"
        )
    points = np.array([_point(*line) for line in rest[:n_points]], dtype=float).reshape(-1, 3)
    cells, coloured = CellCollector(), 0
    for number, words in rest[n_points:]:
        count = whole(words[0], number)
        if count < 1 or len(words) < count + 1:
            raise MeshError(f"line {number}: {len(words) - 1} corners of {count}")
        corners = [whole(word, number) for word in words[1 : count + 1]]
        if min(corners) < 0 or max(corners) >= n_points:
            raise MeshError(f"line {number}: a corner beyond the {n_points} vertices (from 0)")
        coloured += len(words) > count + 1
        cells.add(flat_kind(count), corners)
    notes = [f"colours of {coloured} faces left out"] if coloured else []
    return CellMesh(points, cells.cells(), notes=[*notes, *cut_short(data)])


def _point(number: int, words: list[str]) -> list[float]:
    if len(words) < 3:
        raise MeshError(f"line {number}: a vertex of {len(words)} coordinates")
    return [real(word, number) for word in words[:3]]
