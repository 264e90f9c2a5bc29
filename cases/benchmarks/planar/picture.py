"""The picture of `airfold bench planar`: rates as [T figs. 4.3, 4.5, 4.8], gaps, two models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..report import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw(rows: list[Row], path: Path) -> None:
    """Draw all panels into one file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(18, 13), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    panels: Sequence[Callable[[Axes, list[Row]], None]] = (
        _static,
        _functional,
        _gap_loads,
        _levels("4.3, h", "pancake in h [T fig. 4.3]", 2.0),
        _levels("4.3, dt", "pancake in dt [T fig. 4.3]", 1.0),
        _fold,
        _histories(("pancake", "deflation"), "smallest gap: Stokes flow, uniform pressure"),
        _histories(("fold",), "smallest gap: folds"),
        _heights,
    )
    for axes, panel in zip(figure.subplots(3, 3).ravel(), panels, strict=True):
        panel(axes, rows)
        axes.grid(alpha=0.3)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8)
    figure.savefig(path)


def _of(rows: list[Row], figure: str) -> list[Row]:
    return [row for row in rows if row.get("_figure") == figure]


def _slope(axes: Axes, sizes: Sequence[float], start: float, rate: float) -> None:
    """A dashed line of a known rate from the largest size."""
    x = np.array([max(sizes), min(sizes)])
    y = start * (x / x[0]) ** rate
    axes.loglog(x, y, "k--", linewidth=0.8, label=f"rate {rate:g}")


def _static(axes: Axes, rows: list[Row]) -> None:
    for name, rate in (("Stokes traction", 1.5), ("potential", 2.0)):
        found = _of(rows, name)
        sizes, errors = [row["_size"] for row in found], [row["error"] for row in found]
        axes.loglog(sizes, errors, "o-", label=name)
        _slope(axes, sizes, 0.8 * errors[0], rate)
    axes.set(title="exact flows in a quadrilateral", xlabel="h", ylabel="relative error")


def _functional(axes: Axes, rows: list[Row]) -> None:
    found = _of(rows, "4.5")
    sizes, errors = [row["_size"] for row in found], np.array([row["_errors"] for row in found])
    for k, label in enumerate(("pressure", "load, k = 1", "load, k = 3")):
        axes.loglog(sizes, errors[:, k], "o-", label=label)
    parity = np.maximum([abs(row["load, k=2 over k=1"]) for row in found], 1e-17)
    axes.loglog(sizes, parity, "x:", label="load, k = 2 (its value over that of k = 1)")
    _slope(axes, sizes, 1.3 * errors[0, 0], 1.0)
    _slope(axes, sizes, 1.3 * errors[0, 2], 2.0)
    axes.set(title="load functional [T fig. 4.5]", xlabel="h/L", ylabel="relative error")


def _gap_loads(axes: Axes, rows: list[Row]) -> None:
    for name in ("lubrication", "Venturi"):
        (row,) = _of(rows, name)
        heights, loads = row["_curve"]
        axes.loglog(heights, loads, "o-", label=f"{name}, exponent {row['exponent']:.3f}")
    axes.set(title="load of a squeezed gap", xlabel="half gap H", ylabel="load")


def _levels(figure: str, title: str, rate: float) -> Callable[[Axes, list[Row]], None]:
    def panel(axes: Axes, rows: list[Row]) -> None:
        found = _of(rows, figure)
        sizes, errors = [row["_size"] for row in found], np.array([row["_errors"] for row in found])
        for k, name in enumerate(key for key in found[0] if key.startswith("t <= ")):
            axes.loglog(sizes, errors[:, k], "o-", label=name)
        axes.loglog(sizes, errors[:, -1], "x:", label="position in L2")
        _slope(axes, sizes, 0.7 * errors[0].min(), rate)
        axes.set(title=title, xlabel="size over the whole", ylabel="error in L2(0, t; H2)")

    return panel


def _fold(axes: Axes, rows: list[Row]) -> None:
    for figure in dict.fromkeys(row.get("_figure", "") for row in rows):
        if figure.startswith("4.8"):
            found = _of(rows, figure)
            sizes = [row["_size"] for row in found]
            errors = np.array([row["_errors"] for row in found])
            label = figure.removeprefix("4.8, ")
            axes.loglog(sizes, errors[:, -2], "o-", label=f"H2, {label}")
            axes.loglog(sizes, errors[:, -1], "x:", label=f"position, {label}")
    _slope(axes, sizes, 0.7 * errors[0, -2], 2.0)
    axes.set(title="folded bag, contact force, in h [T fig. 4.8]", xlabel="h/L", ylabel="error")


def _histories(kinds: Sequence[str], title: str) -> Callable[[Axes, list[Row]], None]:
    def panel(axes: Axes, rows: list[Row]) -> None:
        for row in rows:
            if "_history" in row and row["case"].startswith(kinds):
                t, gap = (np.asarray(values) for values in row["_history"])
                style = ":" if "uniform" in row["case"] else "-"
                axes.semilogy(t / t[-1], gap, style, linewidth=1.2, label=row["case"])
        axes.set(title=title, xlabel="t over the end of the run", ylim=(1e-4, None))

    return panel


def _heights(axes: Axes, rows: list[Row]) -> None:
    for label, marker in (("width 20", "o"), ("width 4", "s")):
        found = [row for row in rows if row["case"].startswith(f"{label}, V/V0")]
        ratios = [float(row["case"].split("= ")[1]) - 1.0 for row in found]
        for key, style in (("height", "-"), ("height, uniform", ":")):
            values = [row[key] for row in found]
            axes.plot(ratios, values, style + marker, label=f"{label}: {key}")
    axes.set(title="height over the inlet at equal volumes", xlabel="V/V0 - 1", xscale="log")
