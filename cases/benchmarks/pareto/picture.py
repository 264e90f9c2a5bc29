"""The picture of `airfold bench pareto`: one panel a problem, defaults as stars."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from ..report import Row


def draw(rows: list[Row], path: Path) -> None:
    """Draw error over seconds, a line for each family of settings.

    Parameters
    ----------
    rows : list of dict
        With ``problem``, ``family``, ``setting`` and ``default``.
    path : Path
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    panels = {name: list(group) for name, group in groupby(rows, key=lambda r: r["problem"])}
    figure = Figure(figsize=(6.5 * len(panels), 6.0), dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (problem, points) in zip(
        figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), strict=True
    ):
        for k, (family, group) in enumerate(groupby(points, key=lambda r: r["family"])):
            line = [r for r in group if r["error"] > 0.0]
            colour = f"C{k % 10}"
            axes.loglog(
                [r["seconds"] for r in line],
                [r["error"] for r in line],
                ("o-", "s--", "^:")[k // 3 % 3],
                color=colour,
                label=family,
                markersize=4,
                linewidth=1.0,
            )
            for r in line:
                axes.annotate(
                    r["setting"], (r["seconds"], r["error"]), fontsize=6, color=colour,
                    xytext=(3, 3), textcoords="offset points",
                )  # fmt: skip
        chosen = [r for r in points if r["default"]]
        axes.loglog(
            [r["seconds"] for r in chosen],
            [r["error"] for r in chosen],
            "*",
            color="black",
            markersize=14,
            label="default",
            zorder=5,
        )
        axes.set(title=problem, xlabel="seconds", ylabel=f"error against {points[0]['reference']}")
        axes.yaxis.label.set_wrap(True)
        axes.grid(alpha=0.3, which="both")
        axes.legend(fontsize=7)
    figure.savefig(path)
