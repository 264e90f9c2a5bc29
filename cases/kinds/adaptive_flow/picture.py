"""overview.png of a model-adaptive run: indicators and speed at some steps, errors below.

As [T figs. 7.3, 7.5, 7.8]: indicators on a logarithmic scale on the left; on the right the speed,
the Stokes part darkened. Made from fields.pvd and history.csv alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...output.figures import NoPicture, frames_of, new_figure, save
from ...output.history import read_history
from ...output.vtk import CELLS, read_grid
from .config import AdaptiveFlowScene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

SHOTS = 5
DECADES = 8


@dataclass(frozen=True)
class FlowShot:
    """A step: points ``(n, 2)``, cells ``(m, k)``, cell and point data."""

    step: int
    points: np.ndarray
    cells: np.ndarray
    flagged: np.ndarray
    indicator: np.ndarray
    speed: np.ndarray


def overview(folder: Path, scene: AdaptiveFlowScene) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    NoPicture
        If no frames were written.
    """

    frames = frames_of(folder)
    history = read_history(folder / "history.csv")
    solved = set(history["step"][history["converged"] > 0])
    frames = [frame for frame in frames if frame[0] in solved]
    if not frames:
        raise NoPicture(f"no step of {folder} converged")
    shots = [_read(folder, *frame) for frame in _chosen(frames)]
    adapted = shots[0].cells.shape[1] == 3
    rows = len(shots) + adapted
    figure = new_figure(figsize=(12, 2.9 * rows + 4.6), dpi=110, layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[2.9 * rows, 4.6], squeeze=False)[:, 0]
    axes = upper.subplots(rows, 2, squeeze=False)
    _draw_shots(upper, axes[int(adapted) :], shots, history)
    if adapted:
        _draw_mesh(axes[0], shots[0])
    left, right = lower.subplots(1, 2)
    _draw_errors(left, history)
    _draw_effectivity(right, history)
    return save(figure, folder / "overview.png")


def _chosen(frames: list[tuple[float, str]]) -> list[tuple[float, str]]:
    """The first steps, where most happens, and the last."""
    wanted = [0, 1, 2, 4, len(frames) - 1]
    return [frames[i] for i in sorted({i for i in wanted if i < len(frames)})][:SHOTS]


def _read(folder: Path, t: float, name: str) -> FlowShot:
    mesh = read_grid(folder / name)
    kind = next(k for k in CELLS.values() if k in mesh.cells_dict)
    none = np.zeros(mesh.cells_dict[kind].shape[0])
    return FlowShot(
        int(t),
        mesh.points[:, :2],
        mesh.cells_dict[kind],
        mesh.cell_data["navier-stokes"][0] > 0.5,
        mesh.cell_data.get("indicator", [none])[0],
        np.linalg.norm(mesh.point_data["velocity"], axis=1),
    )


def _draw_shots(
    figure: Figure, axes: np.ndarray, shots: list[FlowShot], history: dict[str, np.ndarray]
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    top = max(np.abs(shot.indicator).max() for shot in shots) or 1.0
    scale = LogNorm(top / 10.0**DECADES, top)
    fastest = max(shot.speed.max() for shot in shots)
    second = ScalarMappable(Normalize(0.0, fastest), "viridis")
    for (left, right), shot in zip(axes, shots, strict=True):
        size = np.maximum(np.abs(shot.indicator), top / 10.0**DECADES)
        first = _cells(left, shot, array=size, norm=scale, cmap="magma")
        colours = second.to_rgba(shot.speed[shot.cells].mean(axis=1))
        colours[~shot.flagged, :3] *= 0.55
        _cells(right, shot, facecolors=colours)
        row = int(np.flatnonzero(history["step"] == shot.step)[0])
        left.set_title(f"step {shot.step}: indicators", fontsize=10)
        right.set_title(_title(history, row), fontsize=10)
    figure.colorbar(first, ax=list(axes[:, 0]), shrink=0.5, label="|indicator|")
    figure.colorbar(second, ax=list(axes[:, 1]), shrink=0.5, label="speed (Stokes part darkened)")


def _draw_mesh(axes: np.ndarray, shot: FlowShot) -> None:
    """The adapted mesh, and a window around its smallest element [T figs. 7.4, 7.7]."""
    from matplotlib.collections import PolyCollection

    polygons = shot.points[shot.cells]
    a, b = polygons[:, 1] - polygons[:, 0], polygons[:, 2] - polygons[:, 0]
    smallest = np.argmin(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    centre = polygons[smallest].mean(axis=0)
    for ax, width, title in zip(
        axes, (0.15, 0.3), (len(polygons), "smallest element"), strict=True
    ):
        lines = PolyCollection(polygons, facecolors="none", edgecolors="black", linewidths=width)
        ax.add_collection(lines)
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.set_axis_off()
        ax.set_title(f"mesh: {title}" + (" triangles" if ax is axes[0] else ""), fontsize=10)
    axes[1].set_xlim(centre[0] - 0.3, centre[0] + 0.3)
    axes[1].set_ylim(centre[1] - 0.2, centre[1] + 0.2)


def _title(history: dict[str, np.ndarray], row: int) -> str:
    estimate, fraction = history["estimate"][row], history["element_fraction"][row]
    text = f"estimate {estimate:.2e}, Navier-Stokes on {fraction:.1%}"
    error = history["error_rel_J0"][row]
    return text + (f", error {error:.2e}" if np.isfinite(error) else "")


def _cells(axes: Axes, shot: FlowShot, **options: Any) -> PolyCollection:
    from matplotlib.collections import PolyCollection

    polygons = shot.points[shot.cells]
    drawn = PolyCollection(polygons, edgecolors="none", antialiased=False, **options)
    drawn.set_rasterized(True)
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()
    return drawn


def _draw_errors(axes: Axes, history: dict[str, np.ndarray]) -> None:
    for name, style in (("bound", "k:"), ("estimate", "o-"), ("error_rel_J0", "x--")):
        size = np.abs(history[name])
        good = np.isfinite(size) & (size > 0.0)
        if good.any():
            axes.semilogy(history["element_fraction"][good], size[good], style, label=name)
    axes.semilogy(
        history["volume_fraction"],
        np.abs(history["estimate"]),
        "s-",
        alpha=0.4,
        label="estimate, over the volume",
    )
    axes.set(xlabel="fraction of Navier-Stokes elements", title="relative to the goal")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9)


def _draw_effectivity(axes: Axes, history: dict[str, np.ndarray]) -> None:
    good = np.isfinite(history["effectivity"])
    axes.axhspan(0.8, 1.25, color="tab:green", alpha=0.15)
    axes.semilogx(np.abs(history["estimate"][good]), history["effectivity"][good], "o-")
    axes.invert_xaxis()
    axes.set_ylim(-1.0, 3.0)
    axes.set(xlabel="|estimate|", title="effectivity: estimate over true error")
    axes.grid(alpha=0.3)
