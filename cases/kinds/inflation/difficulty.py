"""What will be hard about opening a folded bag: contact, touch, snap, films, one line each.

Estimates from a few numbers, beside what they were measured on; `airfold check` prints them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.bag import Bag
from ...geometry.folding import LEAD
from ...output.forecast import Item
from ..inflow import ramp_integral
from .carried import facing_distance, opening_pressure, width_of
from .config import InflationScene, PillowGeometry
from .initial_bag import nature
from .plan import InflationPlan

# Mean over largest bulge of a panel: first contacts of accordions of two folds came at V/V0 = 2.15
# (rigidity 1e-7), 2.3 and 2.7 (1e-5, 4e-6, long panels), where 0.4 says 2.6; of a roll at 1.24 to
# 1.26, where it says 1.24.
BULGE = 0.4
CLAMPED = 384.0  # a clamped strip bulges by p l^4 / (384 rigidity)
# Bulge at the opening pressure over what panels leave between them, times gap over thickness:
# accordions of two folds at 3.2 (panels of six radii, rigidity 1e-5) and 2.5 (ten, 4e-5) opened
# first, at 5.0 (ten, 1e-5) and above panels met.
TOUCHES = 4.0
# 12 m Q length / gap^3 over the opening pressure: at 0.25 an accordion opens as under a uniform
# pressure, at 1.2 panel after panel, at 6 the first panel filled alone and pinched its film.
STRONG, WEAK = 3.0, 0.3


@dataclass(frozen=True)
class Touch:
    """Where sheets of a folded bag meet: what they are, at which V/V0, and how surely."""

    what: str
    volume: float
    surely: bool


def difficulty(plan: InflationPlan) -> tuple[list[Item], list[str]]:
    """Lines of the forecast of a bag that was flat once, and its warnings."""
    scene, bag = plan.scene, plan.bag
    if bag.flat is None:
        return [], []
    items, warnings = contact_lines(bag, plan.carried)
    # a file that brings its flat bag does not tell how it was folded
    if bag.folding is None or not bag.folding.squared_curvature:
        return items, warnings
    pressure = opening_pressure(scene, bag)
    items.append(Item("opening pressure", pressure, "", "the folds' bending energy as work"))
    for more, cautions in (
        _touch(scene, bag, pressure, carries=plan.carried is not None),
        _snap(scene, bag),
        # without rigidity any pressure opens folds, and a group over it says nothing
        _film(scene, bag, pressure) if plan.has_flow and pressure > 0.0 else ([], []),
    ):
        items += more
        warnings += cautions
    return items, warnings


def contact_lines(bag: Bag, carried: object | None) -> tuple[list[Item], list[str]]:
    """Reach and stiffness of contact, and the smallest distance of facing sheets at the start.

    Parameters
    ----------
    bag : Bag
    carried : object with ``reach``, ``stiffness`` and ``floor``, optional
        None without contact forces.
    """
    near = facing_distance(bag)
    note = f"{near / bag.gap:.2g} of the gap; none nearer than that" if near < np.inf else ""
    items = [Item("nearest facing sheets", near, "", note)]
    if carried is None:
        return [*items, Item("contact", "none", "", "sheets that meet end the run")], []
    reach, stiffness, floor = (getattr(carried, k) for k in ("reach", "stiffness", "floor"))
    items += [
        Item("contact reach", reach, "", f"{reach / bag.gap:.2g} of the gap"),
        Item("contact stiffness", stiffness, "", "pressure at half of the reach: 1.2 of it"),
        Item("contact floor", floor, "", "films below it carry less than contact does"),
    ]
    if near >= reach:
        return items, []
    return items, [
        f"sheets face each other {near:.2g} apart at rest, within contact's reach {reach:.2g}: the "
        f"mesh pinches them (refine it), or lower contact.reach to "
        f"{0.9 * near / bag.gap:.2g}"
    ]


def touch(scene: InflationScene, bag: Bag, pressure: float) -> Touch:
    """Where sheets will meet first, from bulging panels between folds that have not opened."""
    fold, c = bag.folds, scene.structure
    if _rolled(scene):
        # the straight end rests on the first turn, whatever the pressure
        return Touch(
            "the straight end and the first turn",
            1.0 + 2.0 * BULGE * LEAD * fold.between / fold.gap,
            True,
        )
    bulge = np.inf
    if c.flexural_rigidity:
        thickness = np.sqrt(12.0 * c.flexural_rigidity)
        bulge = pressure * fold.panel**4 / (CLAMPED * c.flexural_rigidity)
        bulge *= 2.0 / fold.between * fold.gap / thickness
    volume = 1.0 + BULGE * fold.between / fold.gap
    return Touch("neighbouring panels", volume, bool(bulge > TOUCHES))


def _rolled(scene: InflationScene) -> bool:
    return isinstance(scene.geometry, PillowGeometry) and scene.geometry.fold == "roll"


def time_of(scene: InflationScene, volume: float) -> float:
    """Time at which V/V0 is reached; infinite beyond the final volume."""
    i = scene.inflow
    share = (volume - 1.0) / (i.final_volume - 1.0) if i.final_volume != 1.0 else np.inf
    if not 0.0 <= share <= 1.0:
        return np.inf
    times = np.linspace(0.0, i.t1 + i.t2, 1001)
    return float(np.interp(share, [ramp_integral(t, i.t1, i.t2) for t in times], times))


def _touch(
    scene: InflationScene, bag: Bag, pressure: float, *, carries: bool
) -> tuple[list[Item], list[str]]:
    found = touch(scene, bag, pressure)
    when = time_of(scene, found.volume)
    if not np.isfinite(when):
        return [], []
    if not found.surely:
        note = f"{found.what} would, at V/V0 about {found.volume:.2g}, unless folds open before"
        return [Item("touch", "not sure", "", note)], []
    note = f"{found.what}, at V/V0 about {found.volume:.2g}"
    items = [Item("touch", when, "", f"t: {note}")]
    if carries:
        return items, []
    return items, [f"{note}, will meet and end the run; set contact.force = 'barrier'"]


def _snap(scene: InflationScene, bag: Bag) -> tuple[list[Item], list[str]]:
    """Bending energy that folds which have not set bring along."""
    if nature(scene, bag) == "creased":
        return [], []
    rigidity = scene.structure.flexural_rigidity
    energy = rigidity * bag.folds.squared_curvature * width_of(scene, bag)
    # two sheets of unit density, a panel's length to go
    mass = 2.0 * scene.structure.density * width_of(scene, bag)
    time = bag.folds.panel * np.sqrt(0.5 * mass / max(energy, 1e-300))
    grown = 1.0 + (scene.inflow.final_volume - 1.0) * ramp_integral(
        time, scene.inflow.t1, scene.inflow.t2
    )
    items = [
        Item("energy of the folds", energy, "", f"springs a panel open in a time of {time:.2g}")
    ]
    if grown > 1.0 + BULGE * bag.folds.between / bag.folds.gap:
        return items, []
    return items, [
        f"structure.reference = {nature(scene, bag)!r}: folds spring open within t = "
        f"{time:.2g}, when V/V0 is {grown:.2f}: panels' own sheets are sucked onto each other; "
        "'creased' folds wait for the pressure"
    ]


def _film(scene: InflationScene, bag: Bag, pressure: float) -> tuple[list[Item], list[str]]:
    """Pressure that the influx needs through one panel, over the one that opens a fold."""
    i, fold = scene.inflow, bag.folds
    influx = abs(i.final_volume - 1.0) * bag.exact_volume / i.t2 / width_of(scene, bag)
    rolled = _rolled(scene)
    length = 1.0 - LEAD if rolled else fold.panel
    needed = 12.0 * scene.fluid.mass_ratio * influx * length / fold.gap**3
    group = needed / pressure
    words = (
        "opens as under a uniform pressure" if group < WEAK
        else "panels open one after the other" if group < STRONG
        else "the film holds the flow back"
    )  # fmt: skip
    items = [Item("film's group", group, "", f"12 m Q length / gap^3 = {needed:.2g}; {words}")]
    if group <= STRONG or rolled:  # a roll at 4 unrolls: its end fills first in any case
        return items, []
    return items, [
        f"12 m Q length / gap^3 = {needed:.2g} is {group:.2g} times the pressure that opens a "
        "fold: the first panel fills alone and pinches the film behind it; lower fluid.mass_ratio "
        f"to {1.25 / group * scene.fluid.mass_ratio:.1g}, or raise inflow.t2"
    ]
