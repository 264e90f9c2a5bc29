"""What a checkpoint knows of the files beside it, so that damage is seen before a run goes on.

The length and hash of every file at the step of the checkpoint, and the time of every frame. Rows
and frames of later steps lie beyond: they are taken again, with the same result.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .atomic import RecordError, digest, on_disk, remove_parts
from .vtk import FOLDER, LIST, Frames, inside, read_frames, write_frames

HISTORY, CHECKPOINT = "history.csv", "checkpoint.npz"
GROWING = (HISTORY, "iterations.log", "convergence.log")
FRAMES = "frame_*.vtu"
OTHERS = (*GROWING, "run.json")
KEYS = ("name", "size", "hash", "time")  # of the arrays in a checkpoint


@dataclass(frozen=True)
class Mark:
    """How far the files of a folder are: lengths by name, and the number of frames."""

    lengths: Mapping[str, int]
    frames: int


@dataclass(frozen=True)
class _Seal:
    size: int
    hash: str
    time: float  # of a frame; else 0


class Seals:
    """Lengths and hashes of a run folder's files.

    Parameters
    ----------
    folder : Path
    arrays : mapping of arrays, optional
        Of a checkpoint to go on from; the seals' own are taken out of it.

    Attributes
    ----------
    frames : list of (float, str)
        Times and names of the field files; what writes them adds to this list.

    Raises
    ------
    RecordError
        Arrays without seals.
    """

    def __init__(self, folder: Path, arrays: dict[str, np.ndarray] | None = None):
        self.folder = folder
        self._sealed: dict[str, _Seal] = {}
        if arrays is not None:
            try:
                names, *values = (arrays.pop(f"sealed.{key}").tolist() for key in KEYS)
                self._sealed = {
                    inside(name): _Seal(*rest) for name, *rest in zip(names, *values, strict=True)
                }
            except (KeyError, ValueError, TypeError) as error:
                raise RecordError(f"{CHECKPOINT} lacks its seals: {error}") from error
        self.frames: Frames = [
            (seal.time, name) for name, seal in self._sealed.items() if name not in GROWING
        ]

    def mark(self) -> Mark:
        """How far the files are now."""
        lengths = {name: _size(self.folder / name) for name in GROWING}
        return Mark(lengths, len(self.frames))

    def arrays(self, mark: Mark) -> dict[str, np.ndarray]:
        """The seals as arrays for a checkpoint, after the files are on the disk."""
        now: dict[str, _Seal] = {}
        for name, size in mark.lengths.items():
            if size:
                on_disk(self.folder / name)
                now[name] = _Seal(size, digest(self.folder / name, size), 0.0)
        for t, name in self.frames[: mark.frames]:
            path = self.folder / name
            if name in self._sealed:
                now[name] = self._sealed[name]  # a frame is written once
            elif path.exists():
                now[name] = _Seal(_size(path), digest(path, _size(path)), t)
        self._sealed = now
        values = [list(now), *([getattr(s, key) for s in now.values()] for key in KEYS[1:])]
        types = (str, np.int64, str, float)
        return {
            f"sealed.{key}": np.array(v, dtype=type_)
            for key, v, type_ in zip(KEYS, values, types, strict=True)
        }

    def verify(self) -> list[str]:
        """What was lost beside the checkpoint and can be done without, one line each.

        Raises
        ------
        RecordError
            A file that was changed or cut after the checkpoint had been written, or no history.
        """
        if HISTORY not in self._sealed:  # every checkpoint comes after a row
            raise RecordError(f"{CHECKPOINT} does not know {HISTORY}")
        lost = [name for name in self._sealed if not (self.folder / name).exists()]
        if HISTORY in lost:
            raise RecordError(
                f"{HISTORY} is missing; put it back, or start anew: "
                f"airfold run {self.folder / 'run.toml'} --out DIR"
            )
        for name, seal in self._sealed.items():
            path = self.folder / name
            if name not in lost and not self._as_sealed(path, seal, name in GROWING):
                raise RecordError(
                    f"{name} was {'cut' if _size(path) < seal.size else 'changed'} after the "
                    f"checkpoint had been written; put it back, or {_without(name, self.folder)}"
                )
        for file in (self.folder / FOLDER).glob(FRAMES):
            if not file.is_file():
                raise RecordError(f"{FOLDER}/{file.name} is no file; remove it")
        if not (self.folder / "run.json").exists():
            lost.append("run.json")
        notes = [f"{name} was missing: begun anew" for name in lost if name in OTHERS]
        if gone := [name for name in lost if name not in OTHERS]:
            notes.append(f"{len(gone)} field files were missing, {gone[0]} the first")
            self.frames[:] = [frame for frame in self.frames if frame[1] not in gone]
        return notes + self._list_notes()

    @staticmethod
    def _as_sealed(path: Path, seal: _Seal, growing: bool) -> bool:
        whole = growing or _size(path) == seal.size
        return whole and digest(path, seal.size) == seal.hash

    def last_row(self) -> dict[str, str]:
        """The history's row at the checkpoint, by column."""
        with open(self.folder / HISTORY, "rb") as file:
            lines = file.read(self._sealed[HISTORY].size).decode().splitlines()
        return dict(zip(lines[0].split(","), lines[-1].split(","), strict=False))

    def _list_notes(self) -> list[str]:
        try:
            listed = read_frames(self.folder / LIST)[: len(self.frames)] == self.frames
        except RecordError:
            listed = False
        return [] if listed else [f"{LIST} was missing or damaged: made again from its frames"]

    def restore(self) -> None:
        """Cut off and delete what lies beyond the checkpoint, or is unfinished."""
        remove_parts(self.folder)
        for name in GROWING:
            path = self.folder / name
            if name not in self._sealed:
                path.unlink(missing_ok=True)
            elif path.exists():
                os.truncate(path, self._sealed[name].size)
        kept = {name for _, name in self.frames}
        for file in (self.folder / FOLDER).glob(FRAMES):
            if f"{FOLDER}/{file.name}" not in kept:
                file.unlink()
        if self.frames:
            write_frames(self.folder / LIST, self.frames)
        else:
            (self.folder / LIST).unlink(missing_ok=True)


def only_begun(folder: Path, rows: int) -> str:
    """Say that a run begins anew; refuse a folder whose checkpoint must have been lost.

    Parameters
    ----------
    folder : Path
    rows : int
        Rows of the history, and frames, that are written before the first checkpoint.

    Raises
    ------
    RecordError
        More than that is there.
    """
    counts = {name: _lines(folder / name) - 1 for name in GROWING}
    frames = len(list((folder / FOLDER).glob(FRAMES)))
    if counts.pop(HISTORY) > rows or frames > rows or max(counts.values()) > 0:
        raise RecordError(
            f"{CHECKPOINT} is missing, but rows of many steps are there; put it back, or start "
            f"anew: airfold run {folder / 'run.toml'} --out DIR"
        )
    return "earlier rows: there is no checkpoint yet, the run begins anew"


def _without(name: str, folder: Path) -> str:
    if name == HISTORY:
        return f"start anew: airfold run {folder / 'run.toml'} --out DIR"
    return "remove it to go on without it"


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0
