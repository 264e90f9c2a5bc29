"""What a mesh file holds before it is cut into triangles: points, cells of any kind, groups."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..facet_mesh import MeshError

# Integer cell data with more values than this are a field, not labels of groups.
MOST_LABELS = 256


@dataclass(frozen=True)
class Cells:
    """Cells of one kind.

    Attributes
    ----------
    kind : str
        "triangle", "triangle6", "quad", "quad8", "quad9", "polygon", "line", "vertex", a solid's
        name, or whatever the file calls a kind that has no surface here.
    nodes : (m, k) int array
        Indices of points; corners first, then middles of the edges 01, 12, ...
    numbers : (m,) int array
        Number of each cell among all of the file, from 0.
    """

    kind: str
    nodes: np.ndarray
    numbers: np.ndarray


@dataclass(frozen=True)
class CellMesh:
    """Points (n, 3), blocks of cells, groups as cell numbers; `labels`: numbers of the points."""

    points: np.ndarray
    cells: Sequence[Cells]
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None
    reference: np.ndarray | None = None
    notes: Sequence[str] = ()


class CellCollector:
    """Cells one after the other, as text formats give them, with the groups that each is in."""

    def __init__(self) -> None:
        self._nodes: dict[tuple[str, int], list[Sequence[int]]] = defaultdict(list)
        self._numbers: dict[tuple[str, int], list[int]] = defaultdict(list)
        self._groups: dict[str, list[int]] = defaultdict(list)
        self.count = 0

    def add(self, kind: str, nodes: Sequence[int], groups: Iterable[str] = ()) -> int:
        """Number of the new cell."""
        key = kind, len(nodes)
        self._nodes[key].append(nodes)
        self._numbers[key].append(self.count)
        for name in groups:
            self._groups[name].append(self.count)
        self.count += 1
        return self.count - 1

    def cells(self, ids: np.ndarray | None = None) -> list[Cells]:
        """Blocks by kind; `ids` are the point numbers that the nodes speak of, if not indices."""
        blocks = []
        for (kind, _), rows in self._nodes.items():
            nodes, numbers = np.array(rows, dtype=np.int64), np.array(self._numbers[kind, _])
            blocks.append(Cells(kind, nodes if ids is None else places(ids, nodes), numbers))
        return blocks

    def groups(self) -> dict[str, np.ndarray]:
        """Cell numbers by name."""
        return {name: np.unique(numbers) for name, numbers in self._groups.items()}


def flat_kind(count: int) -> str:
    """Kind of a flat cell by its corners."""
    return {1: "vertex", 2: "line", 3: "triangle", 4: "quad"}.get(count, "polygon")


def places(ids: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Indices of the points numbered `wanted`; refused where the file has no such point."""
    if len(ids) == 0:
        raise MeshError("cells but no points in it; export the points too")
    order = np.argsort(ids, kind="stable")
    at = np.clip(np.searchsorted(ids, wanted, sorter=order), 0, len(ids) - 1)
    found = order[at]
    missing = np.argwhere(ids[found] != wanted)
    if len(missing):
        raise MeshError(f"a cell names point {wanted[tuple(missing[0])]}, which the file has not")
    return found


def distinct(ids: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points with numbers that come once; repeated ones must stand at the same place."""
    kept, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
    moved = np.flatnonzero(np.any(points != points[first][inverse], axis=1))
    if len(moved):
        raise MeshError(f"point {ids[moved[0]]} is given twice, at different places; renumber it")
    if len(kept) == len(ids):
        return ids, points
    first = np.sort(first)
    return ids[first], points[first]


def labelled(name: str, values: np.ndarray, numbers: np.ndarray) -> dict[str, np.ndarray]:
    """Groups "name value" of integer cell data; none where it is a field of many values."""
    if values.ndim != 1 or values.dtype.kind not in "iu":
        return {}
    found = np.unique(values)
    if not 0 < len(found) <= MOST_LABELS:
        return {}
    return {f"{name} {value}": numbers[values == value] for value in found}
