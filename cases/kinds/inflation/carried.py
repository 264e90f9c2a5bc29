"""Numbers of the contact potential of a bag: its reach from the gap, its stiffness from a pressure.

A fold opens when the pressure has done its bending energy as work: ``p = rigidity int kappa^2 /
(V_T - V_0)``, both sheets together. Bags of rigidity 1e-6 to 1e-5 were opened by 0.5 to 1.4 times
that, an accordion of thin cloth (1e-7) by 5.4 times; contact lines carry up to four times the
pressure inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coupling.contact.contact_numbers import REACH, STIFFNESS, ContactNumbers, choose_contact

from ...geometry.bag import Bag
from ...geometry.bag_sampler import triangulated
from .config import InflationScene

MARGIN = 1.5  # largest pressure over that of the folds' energy
CLOTH = 4.0  # times that: panels of thin cloth press onto each other before their folds open
LEAST = 2e-4  # of the stiffness: cloth without rigidity still pulls, and sheets still press
FLAT = 0.02  # pressure of a bag without folds, times its extent: half full
FLOOR = 0.4  # of the reach: nearest that sheets come where the stiffness is right


@dataclass(frozen=True)
class Carried:
    """What contact acts by.

    Attributes
    ----------
    reach : float
        Distance from which on sheets push each other apart.
    stiffness : float
        Pressure of the potential: 1.2 times it at half of the reach, 3.3 at three tenths.
    pressure : float
        Largest excess pressure that is forecast.
    """

    reach: float
    stiffness: float
    pressure: float

    @property
    def floor(self) -> float:
        """Distance that contact keeps between sheets."""
        return FLOOR * self.reach


def carried(scene: InflationScene, body: Bag) -> Carried:
    """The numbers of a scene."""
    c = scene.contact
    forecast = opening_pressure(scene, body)
    if scene.structure.law == "tension-field":
        forecast *= CLOTH
    forecast = max(forecast, LEAST * scene.structure.stiffness)
    free = at_rest(body, forecast).reach if body.flat is not None else REACH * body.gap
    return Carried(c.reach * body.gap or free, c.stiffness or STIFFNESS * forecast, forecast)


def at_rest(bag: Bag, pressure: float, cells: int = 3) -> ContactNumbers:
    """Reach at which nothing acts at rest, unless sheets are too near for any, and how near."""
    return choose_contact(triangulated(bag, cells), bag.coefficients, bag.gap, pressure)


def facing_distance(bag: Bag) -> float:
    """Smallest distance of sheets whose normals oppose each other, up to the gap."""
    return min(at_rest(bag, 1.0).facing, bag.gap)


def opening_pressure(scene: InflationScene, body: Bag) -> float:
    """Largest excess pressure expected while the folds of a bag open."""
    turned = 0.0 if body.folding is None else body.folding.squared_curvature
    # bags without folds: sheets as wide as the bag bulge
    if not turned:
        return FLAT * scene.structure.stiffness / body.extent
    rise = abs(scene.inflow.final_volume - 1.0) * body.exact_volume
    work = scene.structure.flexural_rigidity * turned * width_of(scene, body)
    return MARGIN * work / max(rise, 0.1 * body.exact_volume)


def width_of(scene: InflationScene, bag: Bag) -> float:
    """Length of the folds: the width of the flat bag, which lies along x."""
    width = getattr(scene.geometry, "width", None)
    return float(np.ptp(bag.cut[:, 1]) if width is None else width)
