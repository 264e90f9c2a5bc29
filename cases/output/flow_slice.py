"""A picture of the flow in a plane: speed, pressure and streamlines of the plane's components."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hbem.flows.field import FlowField

Flow = Callable[[np.ndarray], FlowField]
AXES = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Slice:
    """A rectangle across the flow.

    Parameters
    ----------
    normal : str
        ``"x"``, ``"y"`` or ``"z"``.
    at : float
        Position along the normal.
    bounds : tuple
        Lower and upper end along the first, then the second of the other axes.
    n : int
        Points along the longer side.

    Raises
    ------
    ValueError
        An unknown axis, empty bounds or fewer than two points.
    """

    normal: str
    at: float
    bounds: tuple[float, float, float, float]
    n: int = 80

    def __post_init__(self) -> None:
        a, b, c, d = self.bounds
        if self.normal not in AXES or not (a < b and c < d) or self.n < 2:
            raise ValueError(
                f"slice: normal must be x, y or z, bounds increasing, n >= 2; got {self}"
            )

    def grid(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Both coordinates of the columns and rows, and the points ``(rows, columns, 3)``."""
        a, b, c, d = self.bounds
        step = max(b - a, d - c) / (self.n - 1)
        first = np.linspace(a, b, max(2, round((b - a) / step) + 1))
        second = np.linspace(c, d, max(2, round((d - c) / step) + 1))
        points = np.full((second.size, first.size, 3), float(self.at))
        i, j = (k for k in range(3) if k != AXES[self.normal])
        points[..., i], points[..., j] = np.meshgrid(first, second)
        return first, second, points


def slice_picture(flow: Flow, where: Slice, path: str | Path) -> Path:
    """Draw speed with streamlines, and pressure, of a flow in a plane.

    Parameters
    ----------
    flow : callable
        Points ``(n, 3)`` to a `FlowField`.
    where : Slice
    path : path of the PNG
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    first, second, points = where.grid()
    field = flow(points.reshape(-1, 3))
    shape = points.shape[:2]
    i, j = (k for k in range(3) if k != AXES[where.normal])
    u = field.velocity.reshape(*shape, 3)
    speed = np.linalg.norm(u, axis=-1)
    figure, axes = plt.subplots(1, 2, figsize=(12, 5), constrained_layout=True)
    for ax, values, name, colours in (
        (axes[0], speed, "speed", "viridis"),
        (axes[1], field.pressure.reshape(shape), "pressure", "RdBu_r"),
    ):
        low, high = np.nanpercentile(values, [1.0, 99.0])
        image = ax.pcolormesh(first, second, values, cmap=colours, vmin=low, vmax=high)
        ax.contour(first, second, field.angle.reshape(shape), [0.5], colors="black", linewidths=1.5)
        figure.colorbar(image, ax=ax, label=f"{name}, scale clipped at 1% and 99%")
        ax.set(aspect="equal", xlabel="xyz"[i], ylabel="xyz"[j])
    if np.nanmax(speed) > 0.0:
        axes[0].streamplot(first, second, u[..., i], u[..., j], color="white", linewidth=0.6)
    figure.suptitle(f"flow in the plane {where.normal} = {where.at:g}")
    figure.savefig(path, dpi=120)
    plt.close(figure)
    return Path(path)
