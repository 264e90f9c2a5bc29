"""fields.pvd and one VTU file a frame, for ParaView and for the pictures.

A frame's file is complete before the list names it, and the list is replaced as a whole, so that
a run can be opened while it is going on.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol
from xml.etree import ElementTree

import numpy as np

from .atomic import SUFFIX, RecordError, on_disk, replacing
from .recorder import Silent

if TYPE_CHECKING:
    import meshio

    from coupling import AcceptedStep, Outcome

FOLDER, LIST = "fields", "fields.pvd"
Frames = list[tuple[float, str]]  # times and file names
CELLS = {
    "quads": "quad",
    "triangles": "triangle",
    "lines": "line",
    "curved": "VTK_LAGRANGE_TRIANGLE",
}


class SurfaceSampler(Protocol):
    """What draws a configuration as cells (see `cases.geometry.bag_sampler`)."""

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None,
        velocity: np.ndarray | None,
        tessellate: int,
    ) -> Mapping[str, Any]:
        """``points (n, 3)``, cells by name in `CELLS`, ``point_data`` and ``cell_data`` by name."""


class Fields(Silent):
    """Recorder of fields.pvd: the first step, every ``every``-th and the last.

    Parameters
    ----------
    path : Path
        Of fields.pvd; frames go into a folder beside it.
    frames : list of (float, str)
        Those of earlier sessions; new ones are added to it.
    traction : bool
        Whether frames carry a traction (zero at the start, where nothing moves).
    """

    def __init__(
        self,
        path: Path,
        sampler: SurfaceSampler,
        frames: Frames,
        *,
        every: int,
        tessellate: int,
        traction: bool,
    ):
        self.path, self.sampler = path, sampler
        self.every, self.tessellate, self.traction = every, tessellate, traction
        self._frames = frames
        self._last: AcceptedStep | None = None

    def on_start(self, step: AcceptedStep) -> None:
        self._frame(step)

    def on_accepted(self, step: AcceptedStep) -> None:
        self._last = step
        if step.step % self.every == 0:
            self._frame(step)

    def close(self, outcome: Outcome) -> None:
        if self._last is not None:
            self._frame(self._last)

    def _frame(self, step: AcceptedStep) -> None:
        name = f"{FOLDER}/frame_{step.step:06d}.vtu"
        if any(name == known for _, known in self._frames):
            return
        coefficients = step.traction.coefficients if step.traction is not None else None
        state = step.state
        grid = self.sampler.surface_grid(
            state.coefficients, coefficients, state.velocity, self.tessellate
        )
        data = dict(grid["point_data"])
        if self.traction and "traction" not in data:
            data["traction"] = np.zeros_like(grid["points"])
        write_grid(self.path.parent / name, {**grid, "point_data": data})
        self._frames.append((state.t, name))
        write_frames(self.path, self._frames)


def write_frames(path: Path, frames: Sequence[tuple[float, str]]) -> None:
    """The list of frames, times and file names, as a fields.pvd."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for t, name in frames:
        ElementTree.SubElement(
            collection, "DataSet", timestep=repr(float(t)), group="", part="0", file=name
        )
    ElementTree.indent(root)
    with replacing(path) as file:
        file.write('<?xml version="1.0"?>\n' + ElementTree.tostring(root, "unicode") + "\n")


def write_grid(path: Path, grid: Mapping[str, Any]) -> None:
    """One VTU file from ``points``, cells by name in `CELLS`, ``point_data``, ``cell_data``."""
    import meshio

    mesh = meshio.Mesh(
        np.asarray(grid["points"]),
        [(kind, np.asarray(grid[key])) for key, kind in CELLS.items() if key in grid],
        point_data={name: np.asarray(v) for name, v in grid["point_data"].items()},
        cell_data={name: [np.asarray(v)] for name, v in grid["cell_data"].items()},
    )
    path.parent.mkdir(exist_ok=True)
    part = path.with_name(path.name + SUFFIX)
    meshio.write(part, mesh, file_format="vtu")
    on_disk(part)
    os.replace(part, path)


def read_grid(path: Path) -> meshio.Mesh:
    """A VTU file of `write_grid`.

    Raises
    ------
    RecordError
        A damaged file.
    """
    from meshio import vtu  # meshio.read would leave the program

    try:
        return vtu.read(path)
    except OSError:
        raise
    except Exception as error:  # a damaged file can raise anything
        raise RecordError(f"{path} is damaged: {type(error).__name__}: {error}") from error


class FlatCells(NamedTuple):
    """Flat pieces ``corners (m, 4)`` of a grid's cells, triangles twice at their last corner.

    ``owner (m,)`` numbers the cell that each is a piece of.
    """

    corners: np.ndarray
    owner: np.ndarray

    def values(self, mesh: meshio.Mesh, name: str) -> np.ndarray | None:
        """Cell data of a name at each piece; None of a grid without it."""
        found = mesh.cell_data.get(name)
        return None if found is None else np.asarray(found[0])[self.owner]


def flat_cells_of(mesh: meshio.Mesh) -> FlatCells:
    """Flat pieces of quadrilaterals, or of curved triangles, of a grid of `write_grid`."""
    block = mesh.cells[0]
    if block.type == CELLS["quads"]:
        return FlatCells(block.data, np.arange(len(block.data)))
    from shells.surfaces.triangles.lagrange_nodes import flat_cells

    each = flat_cells(block.data.shape[1])
    pieces = block.data[:, each[:, [0, 1, 2, 2]]]
    return FlatCells(pieces.reshape(-1, 4), np.repeat(np.arange(len(pieces)), len(each)))


def read_frames(path: Path) -> Frames:
    """Times and file names (relative to the list's folder) of a fields.pvd.

    Raises
    ------
    RecordError
        A damaged list, or a name that leads out of its folder.
    """
    if not path.exists():
        return []
    try:
        entries = list(ElementTree.parse(path).iter("DataSet"))
        return [(float(e.attrib["timestep"]), inside(e.attrib["file"])) for e in entries]
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise RecordError(f"{path} is damaged: {error}") from error


def inside(name: str) -> str:
    """``name``, a relative path that stays below its folder on every system.

    Raises
    ------
    RecordError
        Another one.
    """
    paths = PurePosixPath(name), PureWindowsPath(name)
    if not name.isprintable() or any(p.anchor or ".." in p.parts or not p.parts for p in paths):
        raise RecordError(f"{name!r} leads out of the run folder")
    return name
