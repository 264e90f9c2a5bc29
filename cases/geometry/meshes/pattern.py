"""Folding a flat pattern: all parallel folds in one planar curve of lines and half-turns.

Each fold bends the sheets by 180 degrees about a line across ``along``; "up" and "down" are
sides of the flat pattern, so that alternate sides make an accordion and equal sides a tuck. In
one curve no fold strains another: a bag of thickness g is stretched by ``1 -+ g / (2 radius)``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..fold import PlanarCurve
from ..folding import Folding, Map
from .facet_mesh import MeshError, place
from .flat.plane import fitted_plane

TURN = {"up": 1.0, "down": -1.0}
THICK = 0.1  # thickness over length above which points are no flat pattern
ASLANT = 0.1  # largest share of `along` off the pattern's plane
SAMPLES = 8  # of the curve in a bag's thickness, when layers are looked at


@dataclass(frozen=True)
class HalfTurn:
    """A half-turn about a line across the pattern.

    Attributes
    ----------
    at : float
        Middle of the bend, from the lower end of the pattern along the folding direction.
    side : {"up", "down"}
        To which the rest of the pattern is folded; up is the normal of the pattern's plane
        whose largest component is positive.
    radius : float
        Of the surface midway between the sheets.
    """

    at: float
    side: str
    radius: float

    @property
    def ends(self) -> tuple[float, float]:
        """Where the bend begins and ends along the flat pattern."""
        return self.at - 0.5 * np.pi * self.radius, self.at + 0.5 * np.pi * self.radius


def pattern_folding(
    folds: Sequence[Any],
    along: Sequence[float],
    points: np.ndarray,
    gap: float | None = None,
) -> Folding:
    """How a flat pattern is folded.

    Parameters
    ----------
    folds : sequence of `HalfTurn`
        In any order, in the unit of the points; also mappings and other objects with ``at``,
        ``side`` and ``radius``, and tuples of these.
    along : (3,) array
        Direction from the lower end, in the plane of the pattern.
    points : (n, 3) array
        Of the flat pattern, both sheets.
    gap : float, optional
        Distance of the sheets; default the pattern's thickness.

    Returns
    -------
    Folding
        ``maps[0]`` places the flat pattern: x from its lower end, z off its middle plane, y about
        the middle; ``maps[1]`` folds it, the first panel staying where it is.

    Raises
    ------
    MeshError
        Points that are no flat pattern, a direction off its plane, folds that overlap, leave no
        panel, turn a sheet inside out or lay layers into each other.
    """
    placed, length, thickness = _placement(np.asarray(along, float), points)
    gap = thickness if gap is None else float(gap)
    ordered = sorted((_fold(f, k) for k, f in enumerate(folds)), key=lambda fold: fold.at)
    if not ordered:
        raise MeshError("geometry.folds = []: a pattern is folded by one fold at least")
    panels = _panels(ordered, length, gap)
    lengths, curvatures = [panels[0][1]], [0.0]
    for fold, (a, b) in zip(ordered, panels[1:], strict=True):
        lengths += [np.pi * fold.radius, b - a]
        curvatures += [TURN[fold.side] / fold.radius, 0.0]
    curve = PlanarCurve(tuple(lengths), tuple(curvatures))
    _refuse_collisions(curve, ordered, gap)
    middles = [0.0, *(fold.at for fold in ordered), length]
    return Folding(
        (placed, curve.fold),
        gap,
        min(fold.radius for fold in ordered),
        _between(curve, panels) - gap,
        max(b - a for a, b in pairwise(middles)),
        panels,
        0.5 * panels[0][1],
        curve.squared_curvature,
    )


def _fold(given: Any, k: int) -> HalfTurn:
    """A fold as it may be given, checked."""
    if isinstance(given, Mapping):
        unknown = sorted(set(given) ^ {"at", "side", "radius"})
        if unknown:
            raise MeshError(
                f"geometry.folds[{k}] has or lacks {', '.join(unknown)}: a fold is "
                '{ at = ..., side = "up" or "down", radius = ... }'
            )
        given = HalfTurn(**given)
    elif isinstance(given, Sequence):
        given = HalfTurn(*given)
    else:
        given = HalfTurn(given.at, given.side, given.radius)
    if given.side not in TURN:
        raise MeshError(f'geometry.folds[{k}].side = {given.side!r}: "up" or "down"')
    numbers = all(isinstance(x, int | float) and np.isfinite(x) for x in (given.at, given.radius))
    if not (numbers and given.radius > 0.0):
        raise MeshError(
            f"geometry.folds[{k}]: at = {given.at!r} and radius = {given.radius!r} must be finite "
            "numbers, the radius positive"
        )
    return given


def _placement(along: np.ndarray, points: np.ndarray) -> tuple[Map, float, float]:
    """Map of the pattern to its own coordinates, its length along and its thickness."""
    plane = fitted_plane(points)
    if plane.thickness > THICK * plane.size:
        raise MeshError(
            f"geometry.folds: no flat pattern, {plane.thickness:.3g} thick over {plane.size:.3g}; "
            "folds are given to a flat bag, at most a tenth of its size thick"
        )
    norm = np.linalg.norm(along)
    normal = plane.axes[2]
    if along.shape != (3,) or not norm > 0.0 or abs(along @ normal) > ASLANT * norm:
        raise MeshError(
            f"geometry.along = {along.tolist()}: a direction in the pattern's plane, which is "
            f"normal to {place(normal)}"
        )
    first = along - (along @ normal) * normal
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal, first), normal])
    x = (points - plane.origin) @ axes.T
    low, high = x.min(axis=0), x.max(axis=0)
    origin = plane.origin + np.array([low[0], *(0.5 * (low + high))[1:]]) @ axes

    def placed(points: np.ndarray) -> np.ndarray:
        return (points - origin) @ axes.T

    return placed, float(high[0] - low[0]), plane.thickness


def _panels(folds: list[HalfTurn], length: float, gap: float) -> tuple[tuple[float, float], ...]:
    """Straight ranges between the bends."""
    for fold in folds:
        if not 0.5 * gap < fold.radius:
            raise MeshError(
                f"geometry.folds: the fold at {fold.at:g} turns a sheet inside out: radius = "
                f"{fold.radius:g} must exceed half of the thickness {gap:.3g}"
            )
    marks = [0.0, *(end for fold in folds for end in fold.ends), length]
    panels = tuple(zip(marks[::2], marks[1::2], strict=True))
    names = ["the lower end", *(f"the fold at {f.at:g}" for f in folds), "the upper end"]
    for (a, b), (left, right) in zip(panels, pairwise(names), strict=True):
        if not b - a > 0.0:
            raise MeshError(
                f"geometry.folds: no panel between {left} and {right}: a bend takes pi * radius of "
                f"the pattern's {length:.3g}, and {a - b:.3g} is missing; move the folds apart or "
                "lower a radius"
            )
    return panels


def _refuse_collisions(curve: PlanarCurve, folds: list[HalfTurn], gap: float) -> None:
    """A tube about the curve, as thick as the bag, must not meet itself.

    Along the curve, points farther than ``pi gap / 2`` are at least ``gap`` apart on any bend of
    more than half of the thickness: nearer ones are other layers.
    """
    step = gap / SAMPLES
    t = np.linspace(0.0, curve.length, int(np.ceil(curve.length / step)) + 1)
    points, _ = curve.at(t)
    near = cKDTree(points).query_pairs((1.0 - 1e-9) * gap, output_type="ndarray")
    near = near[np.abs(t[near[:, 0]] - t[near[:, 1]]) > 0.5 * np.pi * gap]
    if not near.size:
        return
    distance = np.linalg.norm(points[near[:, 0]] - points[near[:, 1]], axis=1)
    k = int(distance.argmin())
    a, b = sorted(t[near[k]])
    between = [fold for fold in folds if a < fold.at < b]
    turns = ", ".join(f"{fold.at:g} ({fold.side}, radius {fold.radius:g})" for fold in between)
    raise MeshError(
        f"geometry.folds: layers at {a:.3g} and {b:.3g} along the pattern come within "
        f"{distance[k]:.2g} of each other, and the bag is {gap:.3g} thick: folds at "
        f"{turns}; alternate the sides, or tuck an inner panel in by a smaller radius"
    )


def _between(curve: PlanarCurve, panels: tuple[tuple[float, float], ...]) -> float:
    """Smallest distance of two panels' middles that lie over each other."""
    ends = [curve.at(np.array(panel))[0] for panel in panels]
    found = np.inf
    for k, one in enumerate(ends):
        for other in ends[k + 1 :]:
            low = max(one[:, 0].min(), other[:, 0].min())
            high = min(one[:, 0].max(), other[:, 0].max())
            if low <= high:
                found = min(found, abs(float(one[0, 1] - other[0, 1])))
    return found
