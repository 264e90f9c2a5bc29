"""Folding as a map of space: planar mid-curves of arcs and lines, in closed form.

With arclength t, tangent angle theta and mid-curve c: ``F(t, y, z) = (c_x - z sin theta, y,
c_z + z cos theta)``. Its stretch is exactly ``1 - z kappa`` along the curve and 1 elsewhere: a bag
of inner gap g folded at radius rho is strained by ``g / (2 rho)``. It acts on any point set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class PlanarCurve:
    """A C1 curve of piecewise constant curvature, by arclength.

    Parameters
    ----------
    lengths, curvatures : sequence of float
        Pieces in order; positive curvature turns from x towards z.
    start, angle :
        First point (x, z) and tangent angle there.

    Raises
    ------
    ValueError
        Pieces that do not match or a length that is not positive.
    """

    lengths: Sequence[float]
    curvatures: Sequence[float]
    start: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0

    def __post_init__(self) -> None:
        if len(self.lengths) != len(self.curvatures) or not min(self.lengths) > 0.0:
            raise ValueError("a curve needs one curvature for each piece of positive length")

    @property
    def length(self) -> float:
        return float(np.sum(self.lengths))

    @property
    def squared_curvature(self) -> float:
        """Integral of ``kappa^2`` over the length: twice the bending energy of unit rigidity."""
        return float(np.asarray(self.lengths) @ np.asarray(self.curvatures) ** 2)

    @cached_property
    def _joints(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Arclength, angle and position at the start of each piece."""
        length, k = np.asarray(self.lengths, float), np.asarray(self.curvatures, float)
        t = np.concatenate([[0.0], np.cumsum(length)])[:-1]
        theta = self.angle + np.concatenate([[0.0], np.cumsum(k * length)])[:-1]
        steps = _arc(length, k, theta)
        points = np.asarray(self.start) + np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])
        return t, theta, points[:-1]

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points ``(n, 2)`` and tangent angles ``(n,)`` at arclength t, straight beyond both ends.

        The first and last piece are continued.
        """
        begin, theta, points = self._joints
        piece = np.clip(np.searchsorted(begin, t, side="right") - 1, 0, begin.size - 1)
        d, k = t - begin[piece], np.asarray(self.curvatures, float)[piece]
        return points[piece] + _arc(d, k, theta[piece]), theta[piece] + k * d

    def fold(self, points: np.ndarray) -> np.ndarray:
        """The plain fold map of ``points (n, 3)``: x becomes arclength, z the distance."""
        c, theta = self.at(points[:, 0])
        z = points[:, 2]
        return np.stack(
            [c[:, 0] - z * np.sin(theta), points[:, 1], c[:, 1] + z * np.cos(theta)], axis=1
        )


def _arc(d: np.ndarray, k: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Displacement along arcs of length d: ``d sinc(k d / 2)`` along the mean direction."""
    middle = theta + 0.5 * k * d
    chord = d * np.sinc(0.5 * k * d / np.pi)
    return chord[:, None] * np.stack([np.cos(middle), np.sin(middle)], axis=1)


def zigzag(folds: int, panel: float, radius: float) -> PlanarCurve:
    """Accordion of ``folds`` half-turns between panels of length ``panel``.

    Raises
    ------
    ValueError
        Panels too short for the folds: they must exceed ``pi radius``.
    """
    arc = np.pi * radius
    if folds < 1 or not panel > arc:
        raise ValueError(
            f"an accordion needs folds >= 1 and panel > pi * radius = {arc:.3g}, got {panel:.3g}"
        )
    lengths, curvatures = [panel - 0.5 * arc], [0.0]
    for k in range(folds):
        lengths += [arc, panel - arc]
        curvatures += [(-1.0) ** k / radius, 0.0]
    lengths[-1] = panel - 0.5 * arc
    return PlanarCurve(tuple(lengths), tuple(curvatures))


def roll(turns: float, radius: float, pitch: float, lead: float = 0.0) -> PlanarCurve:
    """Archimedean roll from its inner end, ``radius`` there, ``pitch`` a turn, as short arcs.

    ``lead`` appends a straight end.
    """
    steps = max(1, round(48 * turns))
    angle = 2.0 * np.pi * turns / steps
    r = radius + pitch * turns * (np.arange(steps) + 0.5) / steps
    lengths, curvatures = list(r * angle), list(1.0 / r)
    if lead > 0.0:
        lengths.append(lead)
        curvatures.append(0.0)
    return PlanarCurve(tuple(lengths), tuple(curvatures))
