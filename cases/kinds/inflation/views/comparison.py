"""Two runs of one bag side by side at equal volumes: in space, in cuts y = 0, and as figures.

Shows what resolving the flow changes: a run with a fluid beside one with uniform pressure. Made
from fields.pvd and history.csv alone; each column is one V/V0, met by both runs to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ....output.figures import grown, new_figure, save, section
from .equal_volumes import RunByVolume, common_volumes, largest_excess
from .picture import COLOURS, BagShot, area_quantile, cell_height, common_box, draw_shot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.axes3d import Axes3D

COLUMNS = 5
WIDTH, CURVES = 15.0, 3.4  # inches
RUNS = ("tab:blue", "tab:red")
PLAIN = "#d9d2c4"  # a bag without a traction
FIGURES = {"panel_angle": "largest panel angle, degrees", "pressure": "pressure"}


@dataclass(frozen=True)
class Comparison:
    """A picture of two runs and its figures in words, one line each."""

    picture: Path
    lines: tuple[str, ...]


def comparison(path: Path, folder: Path, other: Path) -> Comparison:
    """Draw two runs of one bag at `COLUMNS` common volumes.

    Parameters
    ----------
    path : Path
        Picture to write.
    folder, other : Path
        Run folders; both start from the same bag.

    Raises
    ------
    NoPicture
        A run without frames, or two runs without a common volume.
    """
    runs = RunByVolume.of(folder), RunByVolume.of(other)
    volumes = common_volumes(*runs, COLUMNS)
    shots = [[run.at(v) for v in volumes] for run in runs]
    low, high = common_box([*shots[0], *shots[1]])
    names = _names(runs)
    tall = cell_height(WIDTH / COLUMNS, low, high)
    flat = WIDTH / COLUMNS * (high[2] - low[2]) / (high[0] - low[0]) + 0.35
    figure = new_figure(figsize=(WIDTH, 2 * tall + flat + CURVES), dpi=100)
    rows = figure.add_gridspec(
        4, 1, height_ratios=[tall, tall, flat, CURVES], left=0.04, right=0.93, top=0.98, bottom=0.06
    )
    for k, run in enumerate(runs):
        colours = _colours(run, shots[k])
        row = rows[k].subgridspec(1, COLUMNS, wspace=0.0)
        for j, shot in enumerate(shots[k]):
            place = row[j].get_position(figure)
            axes = cast("Axes3D", figure.add_axes(grown(place), projection="3d"))
            axes.patch.set_alpha(0.0)
            draw_shot(axes, shot, colours, low, high)
            p = run.figure("pressure", volumes[j : j + 1])[0]
            text = f"V/V₀ = {volumes[j]:.3f}   t = {shot.t:.4g}   p = {p:.2e}"
            figure.text(0.5 * (place.x0 + place.x1), place.y0, text, ha="center", fontsize=8)
            if j == 0:
                figure.text(place.x0, place.y1, names[k], va="top", color=RUNS[k], fontsize=12)
        if run.has_flow:
            _bar(figure, colours, 1.0 - (k + 0.5) * tall / figure.get_size_inches()[1], tall)
    _cuts(figure, rows[2].subgridspec(1, COLUMNS, wspace=0.08), volumes, shots, (low, high))
    _curves(figure, rows[3].subgridspec(1, 2, wspace=0.2), runs, volumes, names)
    return Comparison(save(figure, path), tuple(_table(runs, volumes, names)))


def _names(runs: tuple[RunByVolume, RunByVolume]) -> list[str]:
    """What tells two runs apart: their model, or the names of their folders."""
    models = ["flow" if run.has_flow else "uniform pressure" for run in runs]
    return models if models[0] != models[1] else [run.folder.resolve().name for run in runs]


def _colours(run: RunByVolume, shots: list[BagShot]) -> ScalarMappable:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    if not run.has_flow:
        return ScalarMappable(Normalize(0.0, 1.0), ListedColormap([PLAIN]))
    return ScalarMappable(Normalize(0.0, area_quantile(shots) or 1.0), COLOURS)


def _bar(figure: Figure, colours: ScalarMappable, middle: float, tall: float) -> None:
    height = 0.6 * tall / figure.get_size_inches()[1]
    place = figure.add_axes((0.94, middle - 0.5 * height, 0.008, height))
    bar = figure.colorbar(colours, cax=place, extend="max", format="%.2g")
    bar.ax.tick_params(labelsize=7)
    bar.set_label("traction", fontsize=8)


def _cuts(
    figure: Figure, row: Any, volumes: np.ndarray, shots: list[list[BagShot]], box: Any
) -> None:
    from matplotlib.collections import LineCollection

    margin = 0.03 * float((box[1] - box[0]).max())
    low, high = box[0] - margin, box[1] + margin
    for j, volume in enumerate(volumes):
        axes = figure.add_subplot(row[j])
        for k in range(2):
            shot = shots[k][j]
            lines = section(shot.points, shot.quads)[:, :, [0, 2]]
            axes.add_collection(LineCollection(list(lines), colors=[RUNS[k]], linewidths=1.2))
        axes.set(xlim=(low[0], high[0]), ylim=(low[2], high[2]), aspect="equal")
        axes.set_title(f"cut y = 0, V/V₀ = {volume:.3f}", fontsize=8)
        axes.tick_params(labelsize=7, labelleft=j == 0)


def _curves(
    figure: Figure, row: Any, runs: tuple[RunByVolume, ...], volumes: np.ndarray, names: list[str]
) -> None:
    for j, (column, title) in enumerate(FIGURES.items()):
        axes: Axes = figure.add_subplot(row[j])
        for run, name, colour in zip(runs, names, RUNS, strict=True):
            grown = run.history["volume"] / run.history["volume"][0]
            if column in run.history:
                axes.plot(grown, run.history[column], color=colour, label=name)
                axes.plot(volumes, run.figure(column, volumes), "o", color=colour, markersize=4)
        axes.set(xlabel="V/V₀", ylabel=title)
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(frameon=False, fontsize=9)


def _table(
    runs: tuple[RunByVolume, RunByVolume], volumes: np.ndarray, names: list[str]
) -> list[str]:
    """Figures of both runs at the volumes drawn, and the largest difference of angles between."""
    lines = [f"at equal volumes: {names[0]} | {names[1]}"]
    columns = [[run.figure(c, volumes) for c in ("t", "pressure", "panel_angle")] for run in runs]
    for j, volume in enumerate(volumes):
        cells = [
            f"t = {t[j]:<8.4g} p = {p[j]:<10.3e}"
            + (f" largest panel angle {a[j]:.1f}" if np.isfinite(a[j]) else "")
            for t, p, a in columns
        ]
        lines.append(f"V/V0 = {volume:.3f}  {' | '.join(cells)}")
    excess, at = largest_excess(*runs)
    if np.isfinite(excess):
        lines.append(
            f"largest panel angle of {names[0]} above that of {names[1]} at equal volume: "
            f"{excess:.1f} degrees at V/V0 = {at:.3f}"
        )
    return lines
