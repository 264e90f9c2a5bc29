"""animation.gif: a run at even steps of time, coloured as in overview.png.

Made from fields.pvd and history.csv alone; needs nothing beyond matplotlib. Steps that a run had to
take small would make a movie stall: it shows even times, and points between two frames lie on
straight lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from ....output.figures import frames_of, new_figure
from ....output.history import read_history
from .picture import (
    BagShot,
    area_quantile,
    common_box,
    draw_shot,
    height_seen,
    read_shots,
    title,
)

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

FRAME_TIME = 0.15  # seconds a frame
LARGEST = 120  # frames; of more every second, third ... is taken
WIDTH, TITLE = 7.0, 0.7  # inches
GROWN = 1.3  # size of axes in space over what they show


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
    frames = [*frames[: -1 : -(-len(frames) // LARGEST)], frames[-1]]
    history = read_history(folder / "history.csv")
    shots, quantity = read_shots(folder, frames)
    low, high = common_box(shots)
    top = area_quantile(shots) or 1.0
    colours = ScalarMappable(Normalize(0.0, top), "viridis")
    seen = WIDTH * float(np.clip(height_seen(low, high) / (high[0] - low[0]), 0.4, 1.2))
    size = (WIDTH, seen + TITLE)
    figure = new_figure(figsize=size, dpi=90)
    writer = PillowWriter(fps=round(1.0 / FRAME_TIME))
    path = folder / "animation.gif"
    part = path.with_name("animation.part.gif")
    rim, share = 0.5 * (1.0 - GROWN), seen / size[1]
    with writer.saving(figure, part, dpi=90):
        for shot in at_even_times(shots):
            figure.clear()
            place = (rim, rim * share, GROWN, GROWN * share)
            axes = cast("Axes3D", figure.add_axes(place, projection="3d"))
            draw_shot(axes, shot, colours, low, high)
            text = f"{title(shot.t, history)}\ncolour: {quantity}, 0 to {top:.2g}"
            figure.text(0.5, 1.0 - 0.1 / size[1], text, ha="center", va="top", fontsize=10)
            writer.grab_frame()
    part.replace(path)
    return path


def at_even_times(shots: Sequence[BagShot]) -> Iterator[BagShot]:
    """As many configurations as there are, from the first to the last, at even steps of time."""
    times = np.array([shot.t for shot in shots])
    for t in np.linspace(times[0], times[-1], len(shots)):
        k = min(int(np.searchsorted(times, t, side="right")), len(shots) - 1) - 1
        a, b = shots[k], shots[k + 1]
        share = (t - a.t) / (b.t - a.t) if b.t > a.t else 0.0
        points = (1.0 - share) * a.points + share * b.points
        yield BagShot(float(t), points, a.quads, (1.0 - share) * a.values + share * b.values)
