"""animation.gif of a planar run: the membrane at about equal distances in time."""

from __future__ import annotations

from pathlib import Path

from ...output.figures import new_figure
from ...output.history import read_history
from .picture import common_box, draw_shot, read_shots, title

FRAMES = 60


def animation(folder: Path) -> Path:
    """Draw animation.gif of a run folder, at most 60 frames.

    Raises
    ------
    NoPicture
        If no frames were written.
    """
    from matplotlib.animation import FuncAnimation, PillowWriter

    shots = read_shots(folder, FRAMES)
    history = read_history(folder / "history.csv")
    low, high = common_box(shots)
    ratio = (high[1] - low[1]) / (high[0] - low[0])
    figure = new_figure(figsize=(7, min(7.0, max(2.0, 7.0 * ratio)) + 0.4), dpi=80)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.88))

    def frame(k: int) -> list:
        axes.clear()
        draw_shot(axes, shots[k], low, high)
        axes.set_title(title(shots[k].t, history), fontsize=9)
        return []

    path = folder / "animation.gif"
    part = path.with_name("animation.part.gif")
    FuncAnimation(figure, frame, frames=len(shots)).save(part, writer=PillowWriter(fps=12))
    part.replace(path)
    return path
