"""loads.png: where a bag touches itself and how hard, and where its membrane wrinkles.

Snapshots of the half y >= 0 and cuts y = 0; contact is red, by its pressure, wrinkled and slack
zones are blue. Below, along the volume: samples in contact and their smallest distance, the energy
of contact over that of the membrane, and the wrinkled share of the area. Made from fields.pvd and
history.csv alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ....output.figures import (
    NoPicture,
    frames_of,
    grown,
    new_figure,
    save,
    section_with_cells,
    upper_cells,
)
from ....output.history import read_history
from ....output.vtk import flat_cells_of, read_grid
from .picture import BagShot, cell_height, common_box, draw_surface, title

if TYPE_CHECKING:
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.axes3d import Axes3D

CONTACT, ZONES = "contact_pressure", "wrinkling"
TINTS = {"taut": "#d9d2c4", "wrinkled": "#9ecae1", "slack": "#4a78b0"}
COLUMNS, WIDTH, CURVES = 3, 15.0, 3.2  # inches
QUANTILE = 0.98  # of the cells in contact: pressure where red is deepest


@dataclass(frozen=True)
class Loaded:
    """One frame: its surface, and by cell the contact pressure and the zone (an index of TINTS)."""

    shot: BagShot
    pressure: np.ndarray
    zone: np.ndarray


def loads(folder: Path) -> Path:
    """Draw loads.png of a run folder.

    Raises
    ------
    NoPicture
        Frames with neither contact nor zones.
    """
    history = read_history(folder / "history.csv")
    frames = frames_of(folder)
    shown = [_loaded(folder, *frame) for frame in _spread(frames, history)]
    low, high = common_box([one.shot for one in shown])
    rows = -(-len(shown) // COLUMNS)
    tall = cell_height(WIDTH / COLUMNS, low, high)
    flat = min(WIDTH / len(shown) * float((high[2] - low[2]) / (high[0] - low[0])), 3.0) + 0.4
    figure = new_figure(figsize=(WIDTH, rows * tall + flat + CURVES), dpi=100)
    heights = [*[tall] * rows, flat, CURVES]
    grid = figure.add_gridspec(
        rows + 2, 1, height_ratios=heights, left=0.05, right=0.93, top=0.98, bottom=0.06
    )
    colours = _colours(shown)
    for k, one in enumerate(shown):
        place = grid[k // COLUMNS].subgridspec(1, COLUMNS)[k % COLUMNS].get_position(figure)
        axes = cast("Axes3D", figure.add_axes(grown(place), projection="3d"))
        axes.patch.set_alpha(0.0)
        draw_surface(axes, one.shot, _painted(one, colours), low, high)
        middle = 0.5 * (place.x0 + place.x1)
        figure.text(middle, place.y1, title(one.shot.t, history), ha="center", va="top")
    _legend(figure, colours, shown)
    _cuts(figure, grid[rows].subgridspec(1, len(shown), wspace=0.1), shown, (low, high))
    _curves(figure, grid[rows + 1].subgridspec(1, 3, wspace=0.45), folder, frames, history)
    return save(figure, folder / "loads.png")


def _spread(frames: list[tuple[float, str]], history: dict[str, Any]) -> list[tuple[float, str]]:
    """Frames at even steps of volume: contact comes and goes along all of it."""
    volume = np.interp([t for t, _ in frames], history["t"], history["volume"])
    wanted = np.linspace(volume[0], volume[-1], 2 * COLUMNS)
    return [frames[i] for i in sorted({int(np.argmin(abs(volume - w))) for w in wanted})]


def _loaded(folder: Path, t: float, name: str) -> Loaded:
    mesh = read_grid(folder / name)
    cells = flat_cells_of(mesh)
    quads, zones = cells.corners, cells.values(mesh, ZONES)
    contact = mesh.point_data.get(CONTACT)
    if zones is None and contact is None:
        raise NoPicture(
            f"{folder} has frames without contact and wrinkles: they come with contact.force = "
            "'barrier' and with structure.law = 'tension-field'"
        )
    pressure = np.zeros(len(mesh.points)) if contact is None else contact
    zone = np.zeros(len(quads), dtype=int) if zones is None else zones.astype(int)
    return Loaded(BagShot(t, mesh.points, quads, pressure), pressure[quads].max(axis=1), zone)


def _colours(shown: list[Loaded]) -> ScalarMappable:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    touching = np.concatenate([one.pressure[one.pressure > 0.0] for one in shown])
    top = float(np.quantile(touching, QUANTILE)) if touching.size else 1.0
    return ScalarMappable(Normalize(0.0, top), "YlOrRd")


def _painted(one: Loaded, colours: ScalarMappable) -> np.ndarray:
    """Colour ``(n, 4)`` of each cell in view: its zone, or the contact upon it."""
    from matplotlib.colors import to_rgba

    cells = upper_cells(one.shot.points, one.shot.quads)
    rgba = np.array([to_rgba(tint) for tint in TINTS.values()])[one.zone[cells]]
    touching = one.pressure[cells] > 0.0
    rgba[touching] = colours.to_rgba(one.pressure[cells][touching])
    return rgba


def _legend(figure: Figure, colours: ScalarMappable, shown: list[Loaded]) -> None:
    from matplotlib.patches import Patch

    if any((one.pressure > 0.0).any() for one in shown):
        bar = figure.colorbar(
            colours, cax=figure.add_axes((0.94, 0.6, 0.01, 0.25)), extend="max", format="%.2g"
        )
        bar.set_label("contact pressure")
    if any(one.zone.any() for one in shown):
        patches = [Patch(color=tint, label=name) for name, tint in TINTS.items()]
        figure.legend(handles=patches, loc="upper right", frameon=False, fontsize=9)


def _cuts(figure: Figure, row: Any, shown: list[Loaded], box: tuple[Any, Any]) -> None:
    """Cuts y = 0; where a cell is in contact the line is red, and thick."""
    from matplotlib.collections import LineCollection

    margin = 0.03 * float((box[1] - box[0]).max())
    low, high = box[0] - margin, box[1] + margin
    for k, one in enumerate(shown):
        axes = figure.add_subplot(row[k])
        lines, cells = section_with_cells(one.shot.points, one.shot.quads)
        touching = one.pressure[cells] > 0.0
        for chosen_lines, colour, width in (
            (lines[touching], "tab:red", 3.0),
            (lines, "black", 0.9),
        ):
            if len(chosen_lines):
                flat = list(chosen_lines[:, :, [0, 2]])
                axes.add_collection(LineCollection(flat, colors=[colour], linewidths=width))
        axes.set(xlim=(low[0], high[0]), ylim=(low[2], high[2]), aspect="equal")
        axes.set_title(f"cut y = 0, t = {one.shot.t:.4g}", fontsize=8)
        axes.tick_params(labelsize=6, labelleft=k == 0)


def _curves(
    figure: Figure, row: Any, folder: Path, frames: list[tuple[float, str]], history: dict[str, Any]
) -> None:
    volume = history["volume"] / history["volume"][0]
    panels = [figure.add_subplot(row[j]) for j in range(3)]
    if "contacts" in history:
        panels[0].plot(volume, history["contacts"], color="tab:red")
        panels[0].set(ylabel="samples in contact")
        twin = panels[0].twinx()
        twin.plot(volume, _finite(history.get("contact_distance")), ".", color="grey")
        twin.set_ylabel("smallest distance", color="grey")
    if "contact_energy" in history:
        stored = history["membrane_energy"] + history["bending_energy"]
        # of a bag at rest shares mean nothing
        known = stored > 0.01 * stored.max()
        share = np.where(known, history["contact_energy"] / np.where(known, stored, 1.0), np.nan)
        panels[1].plot(volume, 100.0 * share, color="tab:red")
        panels[1].set(ylabel="contact energy, % of the stored")
    at = np.interp([t for t, _ in frames], history["t"], volume)
    figures = np.array([_figures(_loaded(folder, t, name)) for t, name in frames])
    if figures[:, :2].any():
        for k, name in enumerate(("wrinkled", "slack")):
            panels[2].plot(at, 100.0 * figures[:, k], ".-", color=TINTS[name], label=name)
        panels[2].set(ylabel="% of the area")
    else:
        panels[2].plot(at, figures[:, 2], ".-", color="tab:red", label="largest of contact")
        panels[2].plot(volume, history["pressure"], color="black", label="of the bag")
        panels[2].set(ylabel="pressure")
    panels[2].legend(frameon=False)
    for axes in panels:
        axes.set_xlabel("V/V₀")
        axes.grid(alpha=0.3)


def _finite(values: np.ndarray | None) -> np.ndarray | float:
    return np.nan if values is None else np.where(np.isfinite(values), values, np.nan)


def _figures(one: Loaded) -> tuple[float, float, float]:
    """Shares of the area that are wrinkled and slack, largest contact pressure of a frame."""
    a, b, c, d = (one.shot.points[one.shot.quads[:, k]] for k in range(4))
    area = 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)
    _, wrinkled, slack = np.bincount(one.zone, area, minlength=3) / area.sum()
    return float(wrinkled), float(slack), float(one.pressure.max())
