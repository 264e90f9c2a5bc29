"""The picture of `airfold bench adaptivity`: errors, mesh independence, effectivity, cost."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..report import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def _draw_costs(axes: Axes, rows: list[Row]) -> None:
    """One colour a strategy, one marker a Reynolds number; an exact model sits on the floor."""
    floor, labels = 1e-12, {"Re = 10": "o", "Re = 1000": "^"}
    colours: dict[str, str] = {}
    for row in rows:
        reynolds, _, *words = row["case"].split(", ")
        name = ", ".join(words)
        label = None if name in colours else name
        colour = colours.setdefault(name, f"C{len(colours)}")
        size = max(abs(row["error"]), floor)
        options = {"marker": labels[reynolds], "linestyle": "none", "label": label}
        axes.loglog(row["ratio"], size, color=colour, **options)
    axes.set(
        xlabel="seconds over Navier-Stokes everywhere",
        ylabel="|error|",
        title="error against cost: circles Re = 10, triangles Re = 1000",
    )
    axes.legend(fontsize=8, loc="lower left")


def draw(rows: list[Row], path: Path) -> None:
    """Errors, mesh independence and effectivity as [T figs. 7.10-7.12]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 9), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2)
    colours = {"10": "tab:blue", "100": "tab:orange", "1000": "tab:red"}
    for row in (r for r in rows if "_curve" in r):
        curve = np.array(row["_curve"])
        reynolds, cells = row["case"].split(",")[0].split()[-1], row["case"].split("1/")[1]
        label = f"Re = {reynolds}, h = 1/{cells.split(',')[0]}"
        style = {"10": ":", "20": "--", "40": "-"}[cells.split(",")[0]]
        options = {"color": colours[reynolds], "linestyle": style, "label": label}
        size = np.maximum(np.abs(curve[:, 2]), 1e-16)
        axes[0, 0].semilogy(curve[:, 0], size, marker=".", **options)
        axes[0, 1].semilogy(curve[:, 1], size, marker=".", **options)
        axes[1, 0].semilogx(size, curve[:, 3], marker=".", **options)
    axes[0, 0].set(
        xlabel="fraction of elements", ylabel="|estimate|", title="estimate, by elements"
    )
    axes[0, 1].set(xlabel="fraction of the volume", title="estimate, by volume")
    axes[1, 0].set(xlabel="|estimate|", title="effectivity", ylim=(-1.0, 3.0))
    axes[1, 0].invert_xaxis()
    axes[1, 0].axhline(1.0, color="black", linewidth=0.6)
    axes[0, 0].legend(fontsize=8)
    _draw_costs(axes[1, 1], [r for r in rows if "solves" in r])
    for ax in axes.ravel():
        ax.grid(alpha=0.3)
    figure.savefig(path)
