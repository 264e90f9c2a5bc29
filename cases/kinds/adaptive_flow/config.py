"""A model-adaptive flow as frozen dataclasses: fields with defaults and admissible ranges.

Non-dimensional: largest inflow velocity and channel height are 1, the viscosity is 1 / Re.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ...sections import rule

# The channel and the square cavity below it: (left, right, bottom, top) [T fig. 7.2].
RECTANGLES = ((0.0, 3.0, 0.0, 1.0), (1.0, 2.0, -1.0, 0.0))
LAMINAR = 1500.0


@dataclass(frozen=True)
class Flow:
    """Steady flow through the channel with a cavity.

    ``cells`` counts elements on a unit length; ``refinements = 0`` keeps these quadrilaterals,
    otherwise their triangles are refined so often for the goal, ``refined_fraction`` of them each
    time. ``convection = "skew"`` takes the form of [T 7.13].
    """

    geometry: str = rule("channel-cavity", choices=("channel-cavity",))
    reynolds: float = rule(10.0, above=0.0)
    cells: int = rule(40, least=2, most=160)
    refinements: int = rule(0, least=0, most=14)
    refined_fraction: float = rule(0.15, above=0.0, most=1.0)
    convection: str = rule("plain", choices=("plain", "skew"))


@dataclass(frozen=True)
class Goal:
    """Quantity of interest.

    ``region`` (left, right, bottom, top) belongs to ``vorticity``; ``point``, ``radius`` and
    ``component`` to ``velocity``; ``direction`` to ``traction`` on the walls.
    """

    kind: str = rule("vorticity", choices=("vorticity", "traction", "kinetic-energy", "velocity"))
    region: tuple[float, float, float, float] = rule((1.9, 2.0, -1.0, -0.9))
    point: tuple[float, float] = rule((1.5, -0.5))
    radius: float = rule(0.1, above=0.0)
    component: int = rule(0, least=0, most=1)
    direction: tuple[float, float] = rule((1.0, 0.0))


@dataclass(frozen=True)
class Adaptivity:
    """How the Navier-Stokes part grows.

    ``parameter`` belongs to the marking, ``layers`` to the enriched adjoint. The loop stops when
    the bound, relative to the goal, is below ``tolerance``. ``reference`` solves the full model
    first, so that every step has its true error beside the estimate.
    """

    indicator: str = rule("integral", choices=("integral", "counting", "volume", "exact"))
    marking: str = rule("greedy", choices=("greedy", "fraction", "doerfler"))
    parameter: float = rule(0.1, above=0.0, most=1.0)
    adjoint: str = rule("full", choices=("full", "mixed", "enriched"))
    layers: int = rule(2, least=1)
    tolerance: float = rule(1e-6, above=0.0)
    max_steps: int = rule(40, least=0)
    reference: bool = rule(True)


@dataclass(frozen=True)
class Output:
    """Steps between field files (0: none), and the picture; every step is a checkpoint."""

    fields_every: int = rule(1, least=0)
    picture: bool = rule(True)


@dataclass(frozen=True)
class Scene:
    """Everything a model-adaptive run is made of."""

    kind: ClassVar[str] = "model-adaptivity"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    flow: Flow = Flow()
    goal: Goal = Goal()
    adaptivity: Adaptivity = Adaptivity()
    output: Output = Output()

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {"adaptivity.tolerance": self.adaptivity.tolerance}


SECTIONS: Mapping[str, type] = {
    "flow": Flow,
    "goal": Goal,
    "adaptivity": Adaptivity,
    "output": Output,
}


def impossible(scene: Scene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    f, a = scene.flow, scene.adaptivity
    cases = [
        (
            f.reynolds > LAMINAR,
            f"flow.reynolds: {f.reynolds:g} is out of the laminar range; a steady flow is "
            f"computed up to {LAMINAR:g}",
        ),
        (
            f.refinements > 0 and a.indicator == "exact",
            "adaptivity.indicator: 'exact' shares do not exist on triangles; use 'volume', "
            "'counting' or 'integral', or flow.refinements = 0",
        ),
        *(_region(scene) if scene.goal.kind == "vorticity" else []),
        (
            scene.goal.kind == "velocity" and not _within(_disc(scene.goal)),
            f"goal.point: the disc of radius {scene.goal.radius:g} around "
            f"{list(scene.goal.point)} leaves the domain",
        ),
    ]
    return [message for wrong, message in cases if wrong]


def _region(scene: Scene) -> list[tuple[bool, str]]:
    box, cells = scene.goal.region, scene.flow.cells
    shown = f"goal.region: {list(box)}"
    empty = box[0] >= box[1] or box[2] >= box[3]
    edges = [abs(x * cells - round(x * cells)) > 1e-9 for x in box]
    return [
        (empty, f"{shown} is empty; give left < right, bottom < top"),
        (
            not empty and not _within(box),
            f"{shown} lies outside the domain, the channel [0, 3] x [0, 1] with the cavity "
            "[1, 2] x [-1, 0]",
        ),
        (
            any(edges),
            f"{shown} cuts elements of size 1/{cells}; choose flow.cells so that its sides are "
            "multiples of 1/cells",
        ),
    ]


def _disc(goal: Goal) -> tuple[float, float, float, float]:
    x, y, r = *goal.point, goal.radius
    return (x - r, x + r, y - r, y + r)


def _within(box: tuple[float, float, float, float]) -> bool:
    """Whether the rectangles cover a box: by area, as they do not overlap."""
    area = 0.0
    for left, right, bottom, top in RECTANGLES:
        width = min(box[1], right) - max(box[0], left)
        height = min(box[3], top) - max(box[2], bottom)
        area += max(0.0, width) * max(0.0, height)
    return abs(area - (box[1] - box[0]) * (box[3] - box[2])) < 1e-9
