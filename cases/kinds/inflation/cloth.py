"""Forecast of thin cloth under a tension field: what it can hold, and what resists besides cloth.

Figures of flat square pillows (24 elements around, rigidity 0 or share 1e-4) by `minimise`:
against a bag that wrinkles for free the share k of compression takes ``0.0033 k C / (p L)`` of the
volume (k C / (p L) from 1 to 20), and a folded rim of curvature 2 / thickness the share `TAKEN` of
`OPENED`, ``4 D C / (p t^2)`` with the rigidity D and the sheets' distance t.
"""

from __future__ import annotations

import math

import numpy as np

from shells.surfaces.local_elements import rule

from ...geometry.bag import Bag
from ...geometry.bag_sampler import tangents
from ...output.forecast import Item
from .config import InflationScene, PillowGeometry

LOST = 0.0033
OPENED, TAKEN = (0.044, 0.44, 4.4, 44.0), (0.011, 0.088, 0.25, 0.62)
SHARE = 0.05  # largest k C / (p L)
ROUND = 1.2185242 / math.pi**1.5  # mylar balloon, over (area of a sheet)^(3/2)
STRETCHED = 3.0  # pressure over C / L and the mean strain, of discs and squares


def capacity(scene: InflationScene, area: float) -> float:
    """Volume that a flat bag of sheets of an area can hold, wrinkled but not stretched.

    Exact for discs; rectangles by the rule of tea bags with the limit 0.202 of a square.
    """
    g = scene.geometry
    if not isinstance(g, PillowGeometry) or g.plan == "round":
        return ROUND * area**1.5
    slender = max(g.width, 1.0 / g.width) if g.plan == "rectangle" else 1.0
    rule = (slender / math.pi - 0.129 * (1.0 - 10.0**-slender)) / slender**1.5
    # round corners hold 5 % more for their area: 0.180 at 0.897
    return (1.05 if g.plan == "rectangle" else 1.0) * rule * area**1.5


def cloth(scene: InflationScene, body: Bag, start: float) -> tuple[list[Item], list[str]]:
    """Items and warnings of a tension field; ``start`` is the initial volume."""
    c = scene.structure
    if c.law != "tension-field":
        return [], []
    area = 0.5 * _area(body)
    length, holds = math.sqrt(area), capacity(scene, area)
    filled = scene.inflow.final_volume * start / holds
    items = [Item("volume it can hold", holds, "", f"wrinkled, not stretched; {filled:.0%} at end")]
    unit, warnings = c.stiffness / length, []
    rim = _rim(scene, body)
    if filled < 1.0:
        kept = LOST * c.compression_share * unit / (1.0 - filled)
        items.append(
            Item(
                "pressure of the share",
                kept,
                "",
                f"a slack flat bag's at the end: structure.compression_share = "
                f"{c.compression_share:g}",
            )
        )
        stiff = rim / _interpolated(1.0 - filled, TAKEN, OPENED)
        if stiff > max(kept, 1e-300):
            items.append(Item("pressure of the rim", stiff, "", "the same of its folded rim"))
            warnings.append(_hinge(f"holds a pressure of about {stiff:.2g} at the end"))
        return items, warnings
    pressure = STRETCHED * unit * (filled ** (1.0 / 3.0) - 1.0)
    items.append(Item("pressure at the end", pressure, "", "of the stretch, for a flat bag"))
    ratio = c.compression_share * unit / max(pressure, 1e-300)
    if ratio > SHARE:
        warnings.append(
            f"structure.compression_share = {c.compression_share:g} is not small against the "
            f"pressure {pressure:.2g} at the end: it takes about {min(LOST * ratio, 1.0):.1%} of "
            f"the volume at that pressure, ten times as much of the height; use "
            f"{SHARE * pressure / unit:.1g} or less"
        )
    taken = _interpolated(rim / max(pressure, 1e-300), OPENED, TAKEN) if rim else 0.0
    if taken > 2.0 * TAKEN[0]:
        warnings.append(_hinge(f"takes about {taken:.0%} of the volume at the end's pressure"))
    return items, warnings


def _hinge(effect: str) -> str:
    return (
        f"the folded rim is a stiff hinge: it {effect}; sewn sheets turn freely about their seam: "
        "use structure.seam = 'hinged', a lower structure.flexural_rigidity or a larger "
        "geometry.gap"
    )


def _rim(scene: InflationScene, body: Bag) -> float:
    """Pressure scale 4 D C / t^2 of a pillow's folded rim; 0 of a hinged seam or another bag."""
    c = scene.structure
    if body.folding is None or c.seam == "hinged":
        return 0.0
    return 4.0 * c.stiffness * c.flexural_rigidity / body.folds.gap**2


def _interpolated(x: float, points: tuple[float, ...], values: tuple[float, ...]) -> float:
    """Power laws between measured points, and beyond them."""
    p, v = np.log(points), np.log(values)
    k = int(np.clip(np.searchsorted(p, np.log(x)) - 1, 0, p.size - 2))
    slope = (v[k + 1] - v[k]) / (p[k + 1] - p[k])
    return float(np.exp(v[k] + slope * (np.log(x) - p[k])))


def _area(body: Bag) -> float:
    """Area of membrane and inlet, by a rule of two points; of the flat bag."""
    total, start = 0.0, 0
    for part in body.parts:
        c = body.cut[start : start + part.n_coefficients]
        start += part.n_coefficients
        xi, eta, weights = rule(part.shape, 2)
        size = np.linalg.norm(np.cross(*tangents(part, c, (xi, eta))), axis=1)
        total += float(np.tile(weights, part.n_elements) @ size)
    return total
