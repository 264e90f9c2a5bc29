"""Foldings of a flat bag: the maps of space, and what their rules need to know.

A flat bag lies on ``0 <= x <= 1``, sheets ``gap`` apart. Rules: sheets must not turn inside out
(``|gap kappa / 2| < 1``), panels must be longer than ``pi radius``, and neighbouring layers keep
``pitch - gap`` between them. Lengths in units of the unfolded length.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .fold import roll, zigzag

Map = Callable[[np.ndarray], np.ndarray]
Range = tuple[float, float]
WHOLE: tuple[Range, ...] = ((0.0, 1.0),)


@dataclass(frozen=True)
class Folding:
    """How a flat bag is folded.

    Attributes
    ----------
    maps : tuple of callable
        Maps of points ``(n, 3)``, applied in turn to the flat bag.
    gap : float
        Distance of the two sheets of a panel.
    radius : float
        Smallest fold radius; infinite for a flat bag.
    between : float
        Free distance of neighbouring panels.
    panel : float
        Length of a panel.
    panels : tuple of (float, float)
        Ranges of x between the folds.
    inlet : float
        x of the middle of the inlet, on the lower sheet.
    squared_curvature : float
        Integral of ``kappa^2`` along a sheet, in all directions.
    """

    maps: tuple[Map, ...]
    gap: float
    radius: float
    between: float
    panel: float
    panels: tuple[Range, ...]
    inlet: float
    squared_curvature: float = 0.0

    @property
    def bending(self) -> float:
        """``gap kappa / 2``: the strain of the sheets by the fold, below 1 or inside out."""
        return 0.5 * self.gap / self.radius


def flat(gap: float) -> Folding:
    """Two sheets, no folds; the inlet in the middle of the lower one."""
    return Folding((), gap, np.inf, np.inf, 1.0, WHOLE, 0.5)


def accordion_folding(folds: int, panel: float, gap: float) -> Folding:
    """Zigzag of ``folds`` half turns; ``panel`` and ``gap`` in fold radii.

    Raises
    ------
    ValueError
        Panels too short.
    """
    radius = 1.0 / ((folds + 1) * panel)
    length, arc = panel * radius, np.pi * radius
    curve = zigzag(folds, length, radius)
    ends = length * np.arange(folds + 2)
    panels = tuple(
        (a + 0.5 * arc * (a > 0.0), b - 0.5 * arc * (k < folds))
        for k, (a, b) in enumerate(pairwise(ends))
    )
    return Folding(
        (curve.fold,),
        gap * radius,
        radius,
        (2.0 - gap) * radius,
        length,
        panels,
        0.5 * panels[0][1],
        curve.squared_curvature,
    )


LEAD = 0.2  # straight outer end of a roll, of the bag's length: it holds the inlet


def roll_folding(turns: float, pitch: float, gap: float) -> Folding:
    """Archimedean roll with a straight outer end; ``pitch`` and ``gap`` in inner radii.

    Raises
    ------
    ValueError
        Turns that touch: the pitch must exceed the gap.
    """
    if not pitch > gap:
        raise ValueError(f"turns of a roll touch: pitch = {pitch:g} must exceed gap = {gap:g}")
    radius = (1.0 - LEAD) / (2.0 * np.pi * turns + np.pi * pitch * turns**2)
    curve = roll(turns, radius, pitch * radius, lead=LEAD)
    quarters = np.linspace(0.0, 1.0 - LEAD, max(1, round(4 * turns)) + 1)
    panels = (*pairwise(quarters), (1.0 - LEAD, 1.0))
    return Folding(
        (curve.fold,),
        gap * radius,
        radius,
        (pitch - gap) * radius,
        LEAD,
        panels,
        1.0 - 0.5 * LEAD,
        curve.squared_curvature,
    )


def pack_radius(folds: int, panel: float, gap: float) -> float:
    """Radius of a second fold that clears an accordion: half its height plus a fold radius."""
    radius = 1.0 / ((folds + 1) * panel)
    return radius * (folds + 0.5 * gap + 1.0)


def double_folding(folds: int, folds_across: int, panel: float, gap: float) -> Folding:
    """Accordion in x, then in y at a radius that clears the whole pack (a geometry only).

    The second fold strains the pack by about its half height over the second radius: with a
    finite thickness no package folded in two directions is nearly isometric.
    """
    first = accordion_folding(folds, panel, gap)
    curve = zigzag(folds_across, 1.0 / (folds_across + 1), pack_radius(folds, panel, gap))
    middle, half = folds * first.radius, 0.5 / (folds_across + 1)

    def second(points: np.ndarray) -> np.ndarray:
        turned = np.column_stack([points[:, 1] + 0.5, points[:, 0], points[:, 2] - middle])
        x, y, z = curve.fold(turned).T
        return np.column_stack([y, x - half, z])  # the pack lies about y = 0, as flat bags do

    return Folding(
        (*first.maps, second),
        first.gap,
        first.radius,
        first.between,
        first.panel,
        first.panels,
        first.inlet,
        first.squared_curvature + curve.squared_curvature,
    )
