"""overview.png: six snapshots coloured by traction, meridians, and pressure against volume.

Made from fields.pvd and history.csv alone, so that `airfold report` works on any run folder. The
traction is singular at the inflow rim, hence one scale for all, clipped at its 98% quantile.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from ....output.figures import LIGHT, clipped, frames_of, new_figure, save, section
from ....output.history import read_history
from ....output.vtk import flat_cells_of, read_grid
from ....sections import TimedScene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec
    from mpl_toolkits.mplot3d.axes3d import Axes3D

SNAPSHOTS = 6
QUANTILE = 0.98
COLOURS = "viridis"
ELEVATION = 18.0  # degrees the eye stands above the horizon


@dataclass(frozen=True)
class BagShot:
    """One frame: time, points ``(n, 3)``, quads ``(m, 4)``, scalar ``(n,)`` to colour by."""

    t: float
    points: np.ndarray
    quads: np.ndarray
    values: np.ndarray


def overview(folder: Path, scene: TimedScene) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    NoPicture
        If no frames were written.
    """

    frames = frames_of(folder)
    history = read_history(folder / "history.csv")
    shots, quantity = read_shots(folder, _chosen(frames, history))
    figure = new_figure(figsize=(15, 11.5), dpi=110)
    upper = figure.add_gridspec(2, 3, left=0.03, right=0.91, top=1.02, bottom=0.34, hspace=-0.1)
    lower = figure.add_gridspec(
        1, 2, left=0.06, right=0.93, top=0.33, bottom=0.06, width_ratios=[1.6, 1], wspace=0.32
    )
    draw_shots(figure, upper, shots, history, quantity)
    _draw_meridians(figure.add_subplot(lower[0]), shots)
    _draw_pressure(figure.add_subplot(lower[1]), history, shots)
    return save(figure, folder / "overview.png")


def common_box(shots: list[BagShot]) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the box that holds all snapshots."""
    low = np.min([shot.points.min(axis=0) for shot in shots], axis=0)
    return low, np.max([shot.points.max(axis=0) for shot in shots], axis=0)


def enclosed_volume(points: np.ndarray, quads: np.ndarray) -> float:
    """Volume inside a closed surface of quadrilaterals, each halved along a diagonal."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    cones = np.einsum("ij,ij->", a, np.cross(b, c) + np.cross(c, d))
    return float(abs(cones) / 6.0)


def area_quantile(shots: list[BagShot]) -> float:
    """Value that all but 2% of the area stays below; small elements must not set the scale."""
    values, areas = [], []
    for shot in shots:
        a, b, c, d = (shot.points[shot.quads[:, k]] for k in range(4))
        areas.append(0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1))
        values.append(shot.values[shot.quads].mean(axis=1))
    value, area = np.concatenate(values), np.concatenate(areas)
    order = np.argsort(value)
    share = np.cumsum(area[order])
    return float(value[order][np.searchsorted(share, QUANTILE * share[-1])])


def _chosen(
    frames: list[tuple[float, str]], history: dict[str, np.ndarray]
) -> list[tuple[float, str]]:
    """Frames along growing increments of volume (of time, if it does not change).

    Early frames are the telling ones: the flow shapes the bag before the pressure rounds it.
    """
    if len(frames) <= SNAPSHOTS:
        return frames
    t = np.array([frame[0] for frame in frames])
    measure = np.interp(t, history["t"], history["volume"])
    if np.ptp(measure) < 1e-6 * abs(measure[0]):
        measure = t
    wanted = measure[0] + (measure[-1] - measure[0]) * np.linspace(0.0, 1.0, SNAPSHOTS) ** 2
    index = {int(np.argmin(np.abs(measure - w))) for w in wanted[1:-1]} | {0, len(frames) - 1}
    spare = [i for i in range(1, len(frames)) if i not in index]
    while len(index) < SNAPSHOTS:  # coarse frames: fill with those of early times
        index.add(spare.pop(0))
    return [frames[i] for i in sorted(index)]


def read_shots(folder: Path, frames: list[tuple[float, str]]) -> tuple[list[BagShot], str]:
    """Snapshots and the name of what colours them: traction, or velocity without a fluid."""
    meshes = [read_grid(folder / name) for _, name in frames]
    quantity = "traction" if all("traction" in m.point_data for m in meshes) else "velocity"
    shots = []
    for (t, _), mesh in zip(frames, meshes, strict=True):
        vectors = mesh.point_data.get(quantity, np.zeros_like(mesh.points))
        values = np.linalg.norm(vectors, axis=1)
        shots.append(BagShot(t, mesh.points, flat_cells_of(mesh).corners, values))
    return shots, quantity


def draw_shots(
    figure: Figure,
    grid: GridSpec,
    shots: list[BagShot],
    history: dict[str, np.ndarray],
    quantity: str,
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    low, high = common_box(shots)
    top = area_quantile(shots)
    colours = ScalarMappable(Normalize(0.0, top or 1.0), COLOURS)
    for k, shot in enumerate(shots):
        axes = figure.add_subplot(grid[k // 3, k % 3], projection="3d")
        draw_shot(cast("Axes3D", axes), shot, colours, low, high)
        tall = height_seen(low, high) > 0.8 * (high[0] - low[0])
        axes.set_title(title(shot.t, history), fontsize=12, y=0.89 if tall else 0.83)
    bar = figure.colorbar(
        colours, cax=figure.add_axes((0.925, 0.44, 0.012, 0.46)), extend="max", format="%.3g"
    )
    bar.set_label(f"magnitude of the {quantity}, scale clipped at {QUANTILE:.0%} of the area")


def draw_shot(
    axes: Axes3D, shot: BagShot, colours: ScalarMappable, low: np.ndarray, high: np.ndarray
) -> None:
    """The half y >= 0 of the surface, seen from slightly above, and its cut."""
    _, values = clipped(shot.points, shot.quads, shot.values)
    draw_surface(axes, shot, np.asarray(colours.to_rgba(values)), low, high)


def draw_surface(
    axes: Axes3D, shot: BagShot, rgba: np.ndarray, low: np.ndarray, high: np.ndarray
) -> None:
    """The half y >= 0 in colours ``(n_cells, 4)`` of its cells (`upper_cells`), and its cut."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    polygons, _ = clipped(shot.points, shot.quads, shot.values)
    rgba = rgba.copy()
    rgba[:, :3] *= np.array([_shade(polygon) for polygon in polygons])[:, None]
    axes.add_collection3d(
        Poly3DCollection(polygons, facecolors=rgba, edgecolors=rgba, linewidths=0.3)
    )
    # moved towards the eye, so that the surface behind does not hide half of the line
    tilt = np.radians(ELEVATION)
    towards_eye = 0.05 * (high - low).max() * np.array([0.0, -np.cos(tilt), np.sin(tilt)])
    cut = section(shot.points, shot.quads) + towards_eye
    axes.add_collection3d(Line3DCollection(cut, colors="black", linewidths=1.4))
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(0.0, high[1])
    axes.set_zlim(low[2], high[2])
    box = np.array([2 * half[0], max(high[1], 1e-12), 2 * half[2]])
    # matplotlib scales the box by its diagonal: undo that, so that width or height fills the axes
    zoom = 0.88 * float(np.linalg.norm(box)) / max(box[0], 1.3 * height_seen(low, high))
    axes.set_box_aspect(tuple(box), zoom=zoom)
    axes.view_init(elev=ELEVATION, azim=-90)
    axes.set_proj_type("ortho")
    axes.set_axis_off()


def height_seen(low: np.ndarray, high: np.ndarray) -> float:
    """Height of the half y >= 0 of a box as the eye sees it: its top is in view too."""
    tilt = np.radians(ELEVATION)
    return float((high[2] - low[2]) * np.cos(tilt) + max(high[1], 0.0) * np.sin(tilt))


def cell_height(width: float, low: np.ndarray, high: np.ndarray) -> float:
    """Height of a grid's cell of some width in which `draw_surface` shows a box."""
    return width * min(height_seen(low, high) / float(high[0] - low[0]), 0.85) + 0.35


def _shade(polygon: np.ndarray) -> float:
    """Brightness of a polygon lit from both sides."""
    normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
    size = np.linalg.norm(normal) * np.linalg.norm(LIGHT)
    return 0.68 + 0.32 * abs(normal @ LIGHT) / size if size > 0.0 else 1.0


def title(t: float, history: dict[str, np.ndarray]) -> str:
    volume = np.interp(t, history["t"], history["volume"]) / history["volume"][0]
    pressure = np.interp(t, history["t"], history["pressure"])
    return f"t = {t:.4g}   V/V₀ = {volume:.2f}   p = {pressure:.2e}"


def _draw_meridians(axes: Axes, shots: list[BagShot]) -> None:
    from matplotlib import colormaps
    from matplotlib.collections import LineCollection

    for k, shot in enumerate(shots):
        colour = colormaps["plasma"](0.85 * k / max(1, len(shots) - 1))
        lines = section(shot.points, shot.quads)[:, :, [0, 2]]
        axes.add_collection(LineCollection(list(lines), colors=[colour], linewidths=1.6))
        axes.plot([], [], color=colour, label=f"t = {shot.t:g}")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel="x", ylabel="z", title="cut through the axis")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)


def _draw_pressure(axes: Axes, history: dict[str, np.ndarray], shots: list[BagShot]) -> None:
    if "deformation" in history:
        return _draw_deformation(axes, history)
    t, pressure = history["t"], history["pressure"]
    axes.plot(t, pressure, color="black", label="pressure")
    marks = np.array([shot.t for shot in shots])
    axes.plot(marks, np.interp(marks, t, pressure), "o", color="black", markersize=4)
    axes.set(xlabel="t", ylabel="pressure", title="pressure and volume")
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    twin = axes.twinx()
    twin.plot(t, history["volume"] / history["volume"][0], color="tab:blue")
    twin.set_ylabel("V/V₀", color="tab:blue")
    axes.grid(alpha=0.3)


def _draw_deformation(axes: Axes, history: dict[str, np.ndarray]) -> None:
    """Taylor's deformation of a capsule against that of small-deformation theory."""
    t, found = history["t"], history["deformation"]
    axes.plot(t, found, "o-", color="black", markersize=3, label="coupled run")
    if "to_theory" in history:
        theory = found[-1] / (1.0 + history["to_theory"][-1])
        axes.axhline(theory, color="tab:blue", linestyle="--", label="small-deformation theory")
    axes.set(xlabel="t", ylabel="D = (L - B) / (L + B)", title="deformation")
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
