"""overview.png and animation.gif of a planar run: snapshots as [T figs. 4.4, 5.1-5.3], histories.

Made from fields.pvd and history.csv alone, so that `airfold report` works on any run folder.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...output.figures import frames_of, new_figure, save
from ...output.history import read_history
from ...output.vtk import read_grid
from .config import PlanarScene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOTS = 6
FILL, WALL, INLET = "#dbe9f6", "#12355b", "#d1495b"


@dataclass(frozen=True)
class CurveShot:
    """One frame: time, closed polygon ``(n, 2)``, which of its segments are inlet."""

    t: float
    points: np.ndarray
    inlet: np.ndarray


def overview(folder: Path, scene: PlanarScene) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    NoPicture
        If no frames were written.
    """

    shots = read_shots(folder, SHOTS)
    history = read_history(folder / "history.csv")
    low, high = common_box(shots)
    width, height = high - low
    columns = 1 if width > 4.0 * height else 2 if width > 1.6 * height else 3
    rows = -(-len(shots) // columns)
    tall = min(14.0, rows * (11.0 / columns) * height / width + 0.35 * rows)
    figure = new_figure(figsize=(11, tall + 3.2), dpi=110, layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[tall, 3.2], squeeze=False)[:, 0]
    grid = upper.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(shots) :]:
        axes.set_axis_off()
    for axes, shot in zip(grid, shots, strict=False):
        draw_shot(axes, shot, low, high)
        axes.set_title(title(shot.t, history), fontsize=9)
    _histories(lower.subplots(1, 3), history, [shot.t for shot in shots])
    return save(figure, folder / "overview.png")


def read_shots(folder: Path, count: int) -> list[CurveShot]:
    """At most ``count`` frames at about equal distances in time, first and last among them."""
    frames = frames_of(folder)
    times = np.array([t for t, _ in frames])
    wanted = np.linspace(times[0], times[-1], min(count, len(frames)))
    chosen = sorted({int(np.argmin(np.abs(times - t))) for t in wanted})
    shots = []
    for t, name in (frames[i] for i in chosen):
        mesh = read_grid(folder / name)
        shots.append(CurveShot(t, mesh.points[:, :2], mesh.cell_data["part"][0].astype(bool)))
    return shots


def common_box(shots: list[CurveShot]) -> tuple[np.ndarray, np.ndarray]:
    points = np.concatenate([shot.points for shot in shots])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * (high - low).max()
    return low - margin, high + margin


def draw_shot(axes: Axes, shot: CurveShot, low: np.ndarray, high: np.ndarray) -> None:
    closed = np.concatenate([shot.points, shot.points[:1]])
    axes.fill(*shot.points.T, color=FILL, linewidth=0)
    inlet = np.flatnonzero(shot.inlet)
    axes.plot(*closed[: inlet[0] + 1].T, color=WALL, linewidth=1.0, marker=".", markersize=2)
    axes.plot(*closed[inlet[0] :].T, color=INLET, linewidth=2.0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()


def title(t: float, history: dict[str, np.ndarray]) -> str:
    at = {name: np.interp(t, history["t"], history[name]) for name in ("volume", "pressure")}
    ratio = at["volume"] / history["volume"][0]
    return f"t = {t:g}   V/V₀ = {ratio:.2f}   p = {at['pressure']:.2e}"


def _histories(panels: np.ndarray, history: dict[str, np.ndarray], marks: list[float]) -> None:
    t = history["t"]
    series = [
        ("pressure", ["pressure"], False),
        ("smallest gap", ["min_gap"], True),
        ("stretch", ["stretch_min", "stretch_max"], False),
    ]
    for axes, (title, names, logarithmic) in zip(panels, series, strict=True):
        for name in names:
            axes.plot(t, history[name], color=WALL, linewidth=1.0)
            axes.plot(marks, np.interp(marks, t, history[name]), ".", color=INLET)
        axes.set(title=title, xlabel="t", yscale="log" if logarithmic else "linear")
        axes.grid(alpha=0.3)
