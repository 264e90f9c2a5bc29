"""Picture of a user's mesh before it is run: its triangles, its inlet, and what is wrong where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from shells.surfaces.local_elements import lattice
from shells.surfaces.triangles.lagrange_nodes import lagrange_order

from ....geometry.bag import Bag
from ....geometry.bag_sampler import triangulated
from ....output.figures import LIGHT, new_figure, save, section

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

MEMBRANE, INLET, MARK = "#b9cbe0", "#f08a24", "#d01020"
ORDER = 3  # points along the border of a curved triangle
BORDER = np.array([0, 3, 4, 1, 5, 6, 2, 7, 8])  # nodes of a cubic triangle, once around
VIEWS = (("from above", 30.0), ("from below", -30.0))  # degrees above the horizon
MOST = 20_000  # triangles that are drawn


@dataclass(frozen=True)
class Spot:
    """Something to look at, and where ``(3,)`` it is."""

    what: str
    where: np.ndarray


def mesh_picture(bag: Bag, path: Path, marks: Sequence[Spot] = ()) -> Path:
    """Draw a bag of triangles from both sides and cut: inlet orange, problems as red dots.

    Parameters
    ----------
    bag : Bag
    path : Path
    marks : sequence of Spot
    """
    outlines = [_outlines(bag, k) for k in range(len(bag.parts))]
    polygons = np.concatenate(outlines)
    colours = [MEMBRANE] * len(outlines[0])
    colours += [INLET] * (len(polygons) - len(colours))
    figure = new_figure(figsize=(15, 5.2), dpi=110)
    for k, (name, elevation) in enumerate(VIEWS):
        axes = cast("Axes3D", figure.add_axes((0.01 + 0.33 * k, 0.02, 0.32, 0.88), projection="3d"))
        _draw(axes, polygons, colours, elevation, marks)
        axes.set_title(name, y=0.98)
    _draw_cut(figure, bag, marks)
    _legend(figure, bag, marks)
    return save(figure, path)


def _outlines(bag: Bag, part: int) -> np.ndarray:
    """Borders of the curved triangles of a part, ``(n_elements, 9, 3)``."""
    surface = bag.parts[part]
    start = 0 if part == 0 else bag.n_membrane
    c = bag.coefficients[start : start + surface.n_coefficients]
    xi, eta, _ = lattice("triangle", ORDER)
    points = (surface.sample(xi, eta) @ c).reshape(-1, xi.size, 3)
    return points[:, lagrange_order(ORDER)[BORDER]]


def _draw(
    axes: Axes3D,
    polygons: np.ndarray,
    colours: list[str],
    elevation: float,
    marks: Sequence[Spot],
) -> None:
    from matplotlib.colors import to_rgba
    from matplotlib.ticker import MaxNLocator
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    normal = np.cross(polygons[:, 3] - polygons[:, 0], polygons[:, 6] - polygons[:, 0])
    size = np.maximum(np.linalg.norm(normal, axis=1) * np.linalg.norm(LIGHT), 1e-300)
    rgba = np.array([to_rgba(colour) for colour in colours])
    rgba[:, :3] *= (0.68 + 0.32 * np.abs(normal @ LIGHT) / size)[:, None]
    every = max(1, -(-len(polygons) // MOST))
    axes.add_collection3d(
        Poly3DCollection(
            list(polygons[::every]), facecolors=rgba[::every], edgecolors="#33445588",
            linewidths=0.4,
        )
    )  # fmt: skip
    for mark in marks:
        x, y, z = mark.where
        axes.plot([x], [y], [z], "o", color=MARK, markersize=7, zorder=10)
    low, high = polygons.min(axis=(0, 1)), polygons.max(axis=(0, 1))
    box = np.maximum(high - low, 0.02 * (high - low).max())
    middle = 0.5 * (low + high)
    for k, name in enumerate("xyz"):
        getattr(axes, f"set_{name}lim")(middle[k] - 0.5 * box[k], middle[k] + 0.5 * box[k])
        getattr(axes, f"set_{name}label")(name)
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(4))
    axes.tick_params(labelsize=7, pad=0)
    axes.set_box_aspect(tuple(box), zoom=1.12)
    axes.view_init(elev=elevation, azim=-60)
    axes.set_proj_type("ortho")


def _draw_cut(figure: Any, bag: Bag, marks: Sequence[Spot]) -> None:
    """The cut through the middle of the inlet, or of the bag, along its longer side."""
    from matplotlib.collections import LineCollection

    axes = figure.add_axes((0.72, 0.12, 0.26, 0.76))
    mesh = triangulated(bag, ORDER)
    points = mesh.sample @ bag.coefficients
    centre = points.mean(axis=0)
    if bag.inlet is not None:
        inlet = np.unique(mesh.triangles[mesh.cells // ORDER**2 >= bag.membrane.n_elements])
        centre = points[inlet].mean(axis=0)
    across = int(np.argmin(np.ptp(points, axis=0)[:2]))  # x or y; z stays upright
    order = [1 - across, across, 2]
    lines = section((points - centre)[:, order], mesh.triangles[:, [0, 1, 2, 2]])
    flat = lines[:, :, [0, 2]] + centre[[1 - across, 2]]
    axes.add_collection(LineCollection(list(flat), colors="black", linewidths=1.0))
    axes.autoscale_view()
    axes.set(aspect="equal", xlabel="xy"[1 - across], ylabel="z")
    axes.set_title(f"cut {'xy'[across]} = {centre[across]:.3g}")
    axes.grid(alpha=0.3)


def _legend(figure: Any, bag: Bag, marks: Sequence[Spot]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries: list[Any] = [Patch(color=MEMBRANE, label=f"membrane, {bag.membrane.n_elements}")]
    if bag.inlet is not None:
        entries.append(Patch(color=INLET, label=f"inlet, {bag.inlet.n_elements} triangles"))
    for what in dict.fromkeys(mark.what for mark in marks):
        dot = Line2D([], [], color=MARK, marker="o", linestyle="none", label=what)
        entries.append(dot)
    figure.legend(handles=entries, loc="upper center", ncols=4, frameon=False, fontsize=9)
