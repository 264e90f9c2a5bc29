"""Two runs of one bag side by side: cuts y = 0 at equal volumes.

Shows what resolving the flow changes: a run with a fluid beside one with uniform pressure. Made
from fields.pvd and history.csv alone; frames with the nearest volumes are taken, and each cut is
labelled with its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...output.figures import NoPicture, frames_of, new_figure, save, section
from ...output.history import read_history
from ...output.vtk import read_frames, read_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = 5
WIDTH = 15  # inches
LEGEND = 0.4  # height below each cut, in widths of one
COLOURS = ("tab:blue", "tab:red")


def comparison(path: Path, pairs: Sequence[tuple[Path, Path]]) -> Path:
    """Draw one row of cuts for each pair of run folders.

    Parameters
    ----------
    path : Path
        Picture to write.
    pairs : sequence of (Path, Path)
        Run folders; both of a pair start from the same bag.

    Raises
    ------
    NoPicture
        A run without frames, or two runs without a common volume.
    """

    figure = new_figure(dpi=100, layout="constrained")
    grid = figure.subplots(len(pairs), COLUMNS, squeeze=False)
    heights = []
    for row, pair in zip(grid, pairs, strict=True):
        volumes = [_volumes(folder) for folder in pair]
        for axes, (i, j) in zip(row, _matched(*volumes), strict=True):
            for k, (folder, index) in enumerate(zip(pair, (i, j), strict=True)):
                _cut(axes, folder, index, volumes[k][index], COLOURS[k])
            axes.set_aspect("equal")
            axes.autoscale_view()
            axes.tick_params(labelsize=7)
            axes.legend(
                fontsize=7,
                loc="upper center",
                bbox_to_anchor=(0.5, 0.0),
                borderaxespad=2.5,
                frameon=False,
            )
        row[0].set_ylabel(f"{pair[0].name}\nz")
        heights.append(max(axes.dataLim.height / axes.dataLim.width for axes in row) + LEGEND)
    grid[0, 0].get_gridspec().set_height_ratios(heights)
    figure.set_size_inches(WIDTH, WIDTH / COLUMNS * sum(heights))
    return save(figure, path)


def _volumes(folder: Path) -> np.ndarray:
    """Volume of each frame over the first."""
    frames = frames_of(folder)
    history = read_history(folder / "history.csv")
    volume = np.interp([t for t, _ in frames], history["t"], history["volume"])
    return volume / history["volume"][0]


def _matched(first: np.ndarray, second: np.ndarray) -> list[tuple[int, int]]:
    """Frames of nearest volumes, at even steps of the volume that both runs reach."""
    end = min(first.max(), second.max())
    if not end > 1.0:
        raise NoPicture("the two runs have no growing volume in common")
    wanted = 1.0 + (end - 1.0) * np.linspace(0.0, 1.0, COLUMNS + 1)[1:]
    return [(int(np.argmin(abs(first - v))), int(np.argmin(abs(second - v)))) for v in wanted]


def _cut(axes: Axes, folder: Path, index: int, volume: float, colour: str) -> None:
    from matplotlib.collections import LineCollection

    t, name = read_frames(folder / "fields.pvd")[index]
    mesh = read_grid(folder / name)
    lines = section(mesh.points, mesh.cells_dict["quad"])[:, :, [0, 2]]
    axes.add_collection(LineCollection(list(lines), colors=[colour], linewidths=1.3))
    label = "uniform pressure" if "traction" not in mesh.point_data else "flow"
    axes.plot([], [], color=colour, label=f"{label}, V/V₀ = {volume:.2f}, t = {t:g}")
