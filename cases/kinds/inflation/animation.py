"""animation.gif: the frames of a run one after another, coloured as in overview.png.

Made from fields.pvd and history.csv alone; needs nothing beyond matplotlib.
"""

from __future__ import annotations

from pathlib import Path

from ...output.figures import frames_of, new_figure
from ...output.history import read_history
from .picture import area_quantile, common_box, draw_shot, read_shots, title

FRAME_TIME = 0.15  # seconds a frame
LARGEST = 120  # frames; of more every second, third ... is taken


def animation(folder: Path) -> Path:
    """Draw animation.gif of a run folder.

    Raises
    ------
    NoPicture
        If fewer than two frames were written.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    frames = frames_of(folder, 2)
    frames = frames[:: -(-len(frames) // LARGEST)]
    history = read_history(folder / "history.csv")
    shots, quantity = read_shots(folder, frames)
    low, high = common_box(shots)
    colours = ScalarMappable(Normalize(0.0, area_quantile(shots) or 1.0), "viridis")
    figure = new_figure(figsize=(7, 6), dpi=90)
    writer = PillowWriter(fps=round(1.0 / FRAME_TIME))
    path = folder / "animation.gif"
    part = path.with_name("animation.part.gif")
    with writer.saving(figure, part, dpi=90):
        for shot in shots:
            figure.clear()
            axes = figure.add_subplot(projection="3d")
            draw_shot(axes, shot, colours, low, high)
            axes.set_title(f"{title(shot.t, history)}\ncolour: {quantity}", fontsize=10)
            writer.grab_frame()
    part.replace(path)
    return path
