"""A model-adaptive flow as frozen dataclasses: fields with defaults and admissible ranges.

Non-dimensional: largest inflow velocity and channel height are 1, the viscosity is 1 / Re.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from ...limits import rule
from ...sections import Choice, Sections, StepOutput

# The channel and the square cavity below it: (left, right, bottom, top) [T fig. 7.2].
RECTANGLES = ((0.0, 3.0, 0.0, 1.0), (1.0, 2.0, -1.0, 0.0))
LAMINAR = 1500.0
REFINED = {"flow.refinements": range(1, 15)}
Box = tuple[float, float, float, float]  # left, right, bottom, top


@dataclass(frozen=True)
class ChannelFlow:
    """Steady flow through the channel with a cavity.

    ``cells`` counts elements on a unit length; ``refinements = 0`` keeps these quadrilaterals,
    otherwise their triangles are refined so often for the goal, ``refined_fraction`` of them each
    time. ``convection = "skew"`` takes the form of [T 7.13].
    """

    geometry: str = rule("channel-cavity", choices=("channel-cavity",))
    reynolds: float = rule(10.0, least=1e-6, most=1e6)
    cells: int = rule(40, least=2, most=160)
    refinements: int = rule(0, least=0, most=14)
    refined_fraction: float = rule(0.15, least=1e-3, most=1.0, only=REFINED)
    convection: str = rule("plain", choices=("plain", "skew"))


@dataclass(frozen=True)
class VorticityGoal:
    """Integral of the vorticity over a region (left, right, bottom, top)."""

    kind: str = rule("vorticity", choices=("vorticity",))
    region: tuple[float, float, float, float] = rule((1.9, 2.0, -1.0, -0.9), least=-1.0, most=3.0)


@dataclass(frozen=True)
class VelocityGoal:
    """A velocity component near a point, averaged over a disc."""

    kind: str = rule("velocity", choices=("velocity",))
    point: tuple[float, float] = rule((1.5, -0.5), least=-1.0, most=3.0)
    radius: float = rule(0.1, least=1e-3, most=1.5)
    component: int = rule(0, least=0, most=1)

    @property
    def box(self) -> Box:
        """The square around the disc."""
        (x, y), r = self.point, self.radius
        return (x - r, x + r, y - r, y + r)


@dataclass(frozen=True)
class TractionGoal:
    """Force on the walls in a direction."""

    kind: str = rule("traction", choices=("traction",))
    direction: tuple[float, float] = rule((1.0, 0.0), least=-1e6, most=1e6)


@dataclass(frozen=True)
class EnergyGoal:
    """Kinetic energy of the whole flow."""

    kind: str = rule("kinetic-energy", choices=("kinetic-energy",))


SceneGoal = VorticityGoal | VelocityGoal | TractionGoal | EnergyGoal


@dataclass(frozen=True)
class Adaptivity:
    """How the Navier-Stokes part grows.

    ``parameter`` belongs to the marking, ``layers`` to the enriched adjoint. The loop stops when
    the bound, relative to the goal, is below ``tolerance``. ``reference`` solves the full model
    first, so that every step has its true error beside the estimate.
    """

    indicator: str = rule("integral", choices=("integral", "counting", "volume", "exact"))
    marking: str = rule("greedy", choices=("greedy", "fraction", "doerfler"))
    parameter: float = rule(0.1, least=1e-6, most=1.0)
    adjoint: str = rule("full", choices=("full", "mixed", "enriched"))
    layers: int = rule(2, least=1, most=64, only={"adaptivity.adjoint": ("enriched",)})
    tolerance: float = rule(1e-6, least=1e-14, below=1.0)
    max_steps: int = rule(40, least=0, most=10000)
    reference: bool = rule(True)


@dataclass(frozen=True)
class AdaptiveFlowScene:
    """Everything a model-adaptive run is made of."""

    kind: ClassVar[str] = "model-adaptivity"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    flow: ChannelFlow = ChannelFlow()
    goal: SceneGoal = VorticityGoal()
    adaptivity: Adaptivity = Adaptivity()
    output: StepOutput = field(default_factory=StepOutput)

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {"adaptivity.tolerance": self.adaptivity.tolerance}


SECTIONS: Sections = {
    "flow": ChannelFlow,
    "goal": Choice(
        "goal.kind",
        {
            "vorticity": VorticityGoal,
            "traction": TractionGoal,
            "kinetic-energy": EnergyGoal,
            "velocity": VelocityGoal,
        },
    ),
    "adaptivity": Adaptivity,
    "output": StepOutput,
}


def impossible(scene: AdaptiveFlowScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    f, g, a = scene.flow, scene.goal, scene.adaptivity
    cases = [
        (
            f.reynolds > LAMINAR,
            f"flow.reynolds: {f.reynolds:g} is out of the laminar range; a steady flow is "
            f"computed up to {LAMINAR:g}",
        ),
        (
            isinstance(g, TractionGoal) and not any(g.direction),
            "goal.direction: is zero; give a direction, for example [1.0, 0.0]",
        ),
        (
            f.refinements > 0 and a.indicator == "exact",
            "adaptivity.indicator: 'exact' shares do not exist on triangles; use 'volume', "
            "'counting' or 'integral', or flow.refinements = 0",
        ),
        *(_region(g, f.cells) if isinstance(g, VorticityGoal) else []),
        *(_disc(g) if isinstance(g, VelocityGoal) else []),
    ]
    return [message for wrong, message in cases if wrong]


def _region(goal: VorticityGoal, cells: int) -> list[tuple[bool, str]]:
    box = goal.region
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


def _disc(goal: VelocityGoal) -> list[tuple[bool, str]]:
    message = f"goal.point: the disc of radius {goal.radius:g} around {list(goal.point)} leaves "
    return [(not _within(goal.box), message + "the domain")]


def _within(box: Box) -> bool:
    """Whether the rectangles cover a box: by area, as they do not overlap."""
    area = 0.0
    for left, right, bottom, top in RECTANGLES:
        width = min(box[1], right) - max(box[0], left)
        height = min(box[3], top) - max(box[2], bottom)
        area += max(0.0, width) * max(0.0, height)
    return abs(area - (box[1] - box[0]) * (box[3] - box[2])) < 1e-9
