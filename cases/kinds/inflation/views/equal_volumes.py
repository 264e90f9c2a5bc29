"""Configurations and figures of a run at given volumes, made from its fields.pvd and history.csv.

Frames of one run are the same samples. Between two of them points move on straight lines, up to
where the volume they enclose is the one asked for: on the way of a turning panel that is not where
a linear rule in time would put it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from ....output.figures import NoPicture, frames_of
from ....output.history import read_history
from ....output.vtk import flat_cells_of, read_grid
from .picture import BagShot, enclosed_volume

if TYPE_CHECKING:
    from meshio import Mesh


@dataclass(frozen=True)
class RunByVolume:
    """A run folder whose bag grows, as a function of V/V0.

    Attributes
    ----------
    folder : Path
    frames : list of (float, str)
        Times and file names.
    history : dict of (n,) arrays
    """

    folder: Path
    frames: list[tuple[float, str]]
    history: dict[str, np.ndarray]

    @classmethod
    def of(cls, folder: Path) -> RunByVolume:
        """Read a folder.

        Raises
        ------
        NoPicture
            Fewer than two frames.
        """
        return cls(folder, frames_of(folder, 2), read_history(folder / "history.csv"))

    @cached_property
    def volumes(self) -> np.ndarray:
        """V/V0 of each frame, ``(n_frames,)``."""
        volume = self.history["volume"]
        times = [t for t, _ in self.frames]
        return np.interp(times, self.history["t"], volume) / volume[0]

    @cached_property
    def has_flow(self) -> bool:
        """Whether frames carry a traction."""
        return "traction" in self._grid(0).point_data

    def figure(self, name: str, volumes: np.ndarray) -> np.ndarray:
        """A column of the history where each volume is first reached, interpolated linearly.

        Parameters
        ----------
        name : str
        volumes : (n,) array
            V/V0.

        Returns
        -------
        (n,) array
            NaN without such a column, and for volumes out of reach.
        """
        if name not in self.history:
            return np.full(len(volumes), np.nan)
        largest = np.maximum.accumulate(self.history["volume"] / self.history["volume"][0])
        first = np.flatnonzero(np.diff(largest, prepend=-np.inf) > 0.0)
        values = self.history[name][first]
        return np.interp(volumes, largest[first], values, left=np.nan, right=np.nan)

    def at(self, volume: float) -> BagShot:
        """The configuration of a volume, coloured by the traction's magnitude.

        Parameters
        ----------
        volume : float
            V/V0 between those of two neighbouring frames.

        Raises
        ------
        NoPicture
            A volume that the frames do not reach.
        """
        after = np.flatnonzero((self.volumes[1:] >= volume) & (self.volumes[:-1] <= volume))
        if not after.size:
            raise NoPicture(f"{self.folder} has no frames about V/V0 = {volume:g}")
        k = int(after[0])
        a, b = (self._grid(i) for i in (k, k + 1))
        quads = flat_cells_of(a).corners

        def between(x: np.ndarray, y: np.ndarray, share: float) -> np.ndarray:
            return (1.0 - share) * x + share * y

        # cells have chords inside the surface: what they lack is interpolated, too
        low, high = (enclosed_volume(grid.points, quads) for grid in (a, b))
        v0, v1 = self.volumes[k : k + 2]
        wanted = low + (high - low) * (volume - v0) / (v1 - v0) if v1 > v0 else low

        def beyond(share: float) -> float:
            return enclosed_volume(between(a.points, b.points, share), quads) - wanted

        share = float(brentq(beyond, 0.0, 1.0)) if high > low else 0.0
        x, y = (g.point_data.get("traction", np.zeros_like(g.points)) for g in (a, b))
        values = np.linalg.norm(between(x, y, share), axis=1)
        t = float(self.figure("t", np.array([volume]))[0])
        return BagShot(t, between(a.points, b.points, share), quads, values)

    def _grid(self, k: int) -> Mesh:
        return read_grid(self.folder / self.frames[k][1])


def common_volumes(first: RunByVolume, second: RunByVolume, count: int) -> np.ndarray:
    """Even steps of V/V0 to the largest that both runs reach; the start is left out.

    Raises
    ------
    NoPicture
        None in common.
    """
    end = min(first.volumes.max(), second.volumes.max())
    if not end > 1.0:
        raise NoPicture("the two runs have no growing volume in common")
    return 1.0 + (end - 1.0) * np.linspace(0.0, 1.0, count + 1)[1:]


def largest_excess(
    first: RunByVolume, second: RunByVolume, name: str = "panel_angle"
) -> tuple[float, float]:
    """By how much a column of one run exceeds that of another at equal volume, at most.

    Returns
    -------
    excess, volume : float
        At the V/V0 of a row of either run; NaN where one has no such column.
    """
    end = min(first.volumes.max(), second.volumes.max())
    rows = np.unique(np.concatenate([r.history["volume"] / r.history["volume"][0]
                                     for r in (first, second)]))  # fmt: skip
    rows = rows[(rows >= 1.0) & (rows <= end)]
    excess = first.figure(name, rows) - second.figure(name, rows)
    if not np.isfinite(excess).any():
        return np.nan, np.nan
    k = int(np.nanargmax(excess))
    return float(excess[k]), float(rows[k])
