"""overview.png of a load path: shapes at some loads, and displacements over the load.

Made from fields.pvd, history.csv and run.toml alone; published or exact values are circles.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from ...output.figures import LIGHT, frames_of, new_figure, save
from ...output.history import read_history
from ...output.vtk import flat_cells_of, read_grid
from .config import LoadPathScene
from .published import Reference, reference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHAPES = 5


def overview(folder: Path, scene: LoadPathScene) -> Path:
    """Draw overview.png of a run folder.

    Raises
    ------
    NoPicture
        If no frames were written.
    """

    frames = frames_of(folder)
    known = reference(scene)
    figure = new_figure(figsize=(15, 7.2), dpi=110)
    _draw_shapes(figure, folder, _chosen(frames))
    axes = figure.add_axes((0.63, 0.1, 0.35, 0.82))
    _draw_curves(axes, read_history(folder / "history.csv"), known)
    return save(figure, folder / "overview.png")


def _chosen(frames: list[tuple[float, str]]) -> list[tuple[float, str]]:
    """The first frame, where the shape moves most, and the last."""
    wanted = np.linspace(0.0, 1.0, SHAPES) ** 2 * frames[-1][0]
    loads = np.array([frame[0] for frame in frames])
    return [frames[i] for i in sorted({int(np.abs(loads - w).argmin()) for w in wanted})]


def _draw_shapes(figure: Figure, folder: Path, frames: list[tuple[float, str]]) -> None:
    """Undeformed shape grey, the others from light to dark on one scale of all axes."""
    from matplotlib import colormaps
    from matplotlib.patches import Patch
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    axes = cast(
        Axes3D, figure.add_axes((0.0, 0.0, 0.58, 0.92), projection="3d", computed_zorder=False)
    )
    meshes = [read_grid(folder / name) for _, name in frames]
    polygons, colours, legend = [], [], []
    for k, ((load, _), mesh) in enumerate(zip(frames, meshes, strict=True)):
        colour = np.array(colormaps["viridis"](1.0 - k / max(1, len(frames) - 1)))
        if load == 0.0:
            colour = np.array([0.75, 0.75, 0.75, 1.0])
        quads = mesh.points[flat_cells_of(mesh).corners]
        shaded = np.tile(colour, (len(quads), 1))
        shaded[:, :3] *= _shades(quads)[:, None]
        polygons.append(quads)
        colours.append(shaded)
        legend.append(Patch(color=tuple(colour), label=f"load {load:.3g}"))
    # one collection: matplotlib sorts polygons by depth only within one
    faces = np.concatenate(colours)
    axes.add_collection3d(
        Poly3DCollection(
            np.concatenate(polygons), facecolors=faces, edgecolors=faces, linewidths=0.2
        )
    )
    points = np.concatenate([mesh.points for mesh in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    box = np.maximum(high - low, 0.02 * (high - low).max())
    axes.set(xlim=(low[0], low[0] + box[0]), ylim=(low[1], low[1] + box[1]))
    axes.set(zlim=(low[2], low[2] + box[2]), xlabel="x", ylabel="y", zlabel="z")
    axes.set_box_aspect(tuple(box))
    axes.view_init(elev=20.0, azim=-65)
    axes.set_proj_type("ortho")
    axes.locator_params(nbins=4)
    for axis, width in zip((axes.xaxis, axes.yaxis, axes.zaxis), box, strict=True):
        if width < 0.2 * box.max():  # no room for numbers
            axis.set_ticks([])
    figure.legend(handles=legend, loc="upper left", frameon=False, ncols=len(legend))


def _shades(quads: np.ndarray) -> np.ndarray:
    """Brightness of quadrilaterals ``(n, 4, 3)`` lit from both sides."""
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    size = np.linalg.norm(normal, axis=1) * np.linalg.norm(LIGHT)
    return 0.62 + 0.38 * np.abs(normal @ LIGHT) / np.maximum(size, 1e-300)


def _draw_curves(axes: Axes, history: dict[str, np.ndarray], known: Reference | None) -> None:
    columns = known.columns if known else _moving(history)
    for k, (name, sign) in enumerate(columns):
        label = ("-" if sign < 0 else "") + name.replace("_", " ")
        axes.plot(sign * history[name], history["load"], color=f"C{k}", label=label)
        if known:
            values = [(known.at(f), f) for f in known.fractions]
            marks = np.array([(v[k], f) for v, f in values if v is not None])
            axes.plot(*marks.T, "o", color=f"C{k}", fillstyle="none")
    if known:
        axes.plot([], [], "o", color="black", fillstyle="none", label=known.source)
    seen = history["deviation"][np.isfinite(history["deviation"]) & (history["load"] > 0.0)]
    title = f"largest deviation {seen.max():.1e}" if seen.size else "load and displacement"
    axes.set(xlabel="displacement", ylabel="load fraction", title=title)
    axes.grid(alpha=0.3)
    axes.legend()


def _moving(history: dict[str, np.ndarray]) -> list[tuple[str, float]]:
    """Displacement columns that are not zero by symmetry."""
    names = [name for name in history if name[-2:] in ("_x", "_y", "_z")]
    top = max(np.abs(history[name]).max() for name in names)
    return [(name, 1.0) for name in names if np.abs(history[name]).max() > 1e-9 * top]
