"""The picture of `airfold bench pareto`: one panel a problem, defaults as stars."""

from __future__ import annotations

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

    panels = _by(rows, "problem")
    across = min(3, len(panels))
    down = -(-len(panels) // across)
    figure = Figure(figsize=(6.5 * across, 6.0 * down), dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    for number, (problem, points) in enumerate(panels.items(), start=1):
        axes = figure.add_subplot(down, across, number)
        for k, (family, group) in enumerate(_by(points, "family").items()):
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


def _by(rows: list[Row], key: str) -> dict[str, list[Row]]:
    """Rows by the value of a key, in the order of first appearance."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return found
