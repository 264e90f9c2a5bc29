"""fields.pvd and one VTU file a frame, for ParaView and for the pictures.

A frame's file is complete before the list names it, and the list is replaced as a whole, so that
a run can be opened while it is going on.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol
from xml.etree import ElementTree

import numpy as np

from .atomic import SUFFIX, replacing
from .recorder import Silent

if TYPE_CHECKING:
    from coupling import AcceptedStep, Outcome

FOLDER = "fields"
CELLS = {"quads": "quad", "triangles": "triangle", "lines": "line"}


class SurfaceSampler(Protocol):
    """What draws a configuration as quadrilaterals (see `cases.geometry.bag_sampler`)."""

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None,
        velocity: np.ndarray | None,
        tessellate: int,
    ) -> Mapping[str, Any]:
        """``points (n, 3)``, ``quads (m, 4)``, ``point_data`` and ``cell_data`` by name."""


class Fields(Silent):
    """Recorder of fields.pvd: the first step, every ``every``-th and the last.

    Parameters
    ----------
    path : Path
        Of fields.pvd; frames go into a folder beside it.
    traction : bool
        Whether frames carry a traction (zero at the start, where nothing moves).
    """

    def __init__(
        self, path: Path, sampler: SurfaceSampler, *, every: int, tessellate: int, traction: bool
    ):
        self.path, self.sampler = path, sampler
        self.every, self.tessellate, self.traction = every, tessellate, traction
        self._frames: list[tuple[float, str]] = []
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

    def cut_back(self, step: int) -> None:
        """Forget frames after ``step``, and those an earlier end wrote out of turn."""
        kept = []
        for t, name in read_frames(self.path):
            number = int(Path(name).stem.split("_")[-1])
            if number <= step and number % self.every == 0:
                kept.append((t, name))
        self._frames = kept
        self._write_list()
        for file in (self.path.parent / FOLDER).glob("frame_*.vtu"):
            if f"{FOLDER}/{file.name}" not in {name for _, name in kept}:
                file.unlink()

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
        self._write_list()

    def _write_list(self) -> None:
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
    os.replace(part, path)


def read_frames(path: Path) -> list[tuple[float, str]]:
    """Times and file names (relative to the list's folder) of a fields.pvd."""
    if not path.exists():
        return []
    entries = ElementTree.parse(path).iter("DataSet")
    return [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in entries]
