"""A shell under a growing load as frozen dataclasses: fields, defaults and admissible ranges.

The only kind with dimensional numbers, in any consistent units: those of the published benchmarks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ...limits import rule
from ...sections import Choice, Sections, StepOutput


@dataclass(frozen=True)
class StripGeometry:
    """A flat strip, clamped at the start of its length, loaded at the other end."""

    kind: str = rule("strip", choices=("strip",))
    length: float = rule(10.0, above=0.0, most=1e20)
    width: float = rule(1.0, above=0.0, most=1e20)

    @property
    def path(self) -> float:
        """Length from the clamped to the loaded end."""
        return self.length

    @property
    def across(self) -> float:
        """Length of the loaded end."""
        return self.width


@dataclass(frozen=True)
class AnnulusGeometry:
    """A flat annulus slit along the x axis; one lip of the slit is clamped, the other loaded."""

    kind: str = rule("annulus", choices=("annulus",))
    inner: float = rule(6.0, above=0.0, most=1e20)
    outer: float = rule(10.0, above=0.0, most=1e20)

    @property
    def path(self) -> float:
        """Length from the clamped to the loaded lip, halfway between the radii."""
        return math.pi * (self.inner + self.outer)

    @property
    def across(self) -> float:
        """Length of the loaded lip."""
        return self.outer - self.inner


@dataclass(frozen=True)
class ShellMesh:
    """Spline degree, elements from the clamped to the loaded end and across."""

    degree: int = rule(3, choices=(2, 3, 4))
    along: int = rule(16, least=2, most=1024)
    across: int = rule(1, least=1, most=1024)


@dataclass(frozen=True)
class ShellSection:
    """Isotropic St. Venant-Kirchhoff material in plane stress.

    ``membrane = "reduced"`` takes the reduced points of the membrane energy that do not lock.
    """

    thickness: float = rule(0.1, above=0.0, most=1e20)
    young_modulus: float = rule(1.2e6, above=0.0, most=1e20)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)
    membrane: str = rule("gauss", choices=("gauss", "reduced"))


@dataclass(frozen=True)
class EndForce:
    """A force per unit of the loaded end that keeps its direction; it grows in equal steps.

    A step whose equilibrium is not found is halved, down to a millionth of the path.
    """

    kind: str = rule("force", choices=("force",))
    force: tuple[float, float, float] = rule((0.0, 0.0, 4.0), least=-1e20, most=1e20)
    steps: int = rule(20, least=1, most=10000)


@dataclass(frozen=True)
class EndMoment:
    """A moment per unit of the loaded end that turns with it, positive towards +z."""

    kind: str = rule("moment", choices=("moment",))
    moment: float = rule(10.0, least=-1e20, most=1e20)
    steps: int = rule(20, least=1, most=10000)


@dataclass(frozen=True)
class LoadPathOutput(StepOutput):
    """As `StepOutput`, with the cells of a field file per element and direction."""

    tessellate: int = rule(3, least=1, most=10)


@dataclass(frozen=True)
class LoadPathScene:
    """Everything a load path is made of."""

    kind: ClassVar[str] = "shell"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    geometry: StripGeometry | AnnulusGeometry = StripGeometry()
    mesh: ShellMesh = ShellMesh()
    structure: ShellSection = ShellSection()
    load: EndForce | EndMoment = EndForce()
    output: LoadPathOutput = LoadPathOutput()

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {"newton.update": NEWTON}


THINNEST, SLENDEREST = 1e-7, 1e4
SMALLEST = 1e-9  # rotation of the loaded end by linear theory
NEWTON = 1e-9  # largest Newton update over the extent of the shell
SECTIONS: Sections = {
    "geometry": Choice("geometry.kind", {"strip": StripGeometry, "annulus": AnnulusGeometry}),
    "mesh": ShellMesh,
    "structure": ShellSection,
    "load": Choice("load.kind", {"force": EndForce, "moment": EndMoment}),
    "output": LoadPathOutput,
}


def impossible(scene: LoadPathScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    g, h, f = scene.geometry, scene.structure.thickness, scene.load
    named = "geometry.width" if isinstance(g, StripGeometry) else "geometry.outer - geometry.inner"
    cases = [
        (
            isinstance(g, AnnulusGeometry) and g.across <= 0.0,
            f"geometry.outer: {getattr(g, 'outer', 0.0):g} must exceed geometry.inner = "
            f"{getattr(g, 'inner', 0.0):g}",
        ),
        (
            g.across > 0.0 and h > min(g.across, g.path),
            f"structure.thickness: {h:g} makes this no shell; it must be below {named} = "
            f"{g.across:g} and the length {g.path:.4g}",
        ),
        (
            h < THINNEST * max(g.path, abs(g.across)),
            f"structure.thickness: {h:g} is below {THINNEST:g} of the shell's length {g.path:.4g}: "
            "rounding hides its bending; raise it",
        ),
        (
            not 1.0 / SLENDEREST <= abs(g.across) / g.path <= SLENDEREST,
            f"geometry: {g.path:.4g} long and {g.across:.4g} across; lengths must be within "
            f"{SLENDEREST:g} of each other",
        ),
        (
            isinstance(f, EndForce) and math.hypot(*f.force) > scene.structure.young_modulus * h,
            f"load.force: {list(getattr(f, 'force', ()))} exceeds young_modulus x thickness = "
            f"{scene.structure.young_modulus * h:.3g}: strains above 1; lower it",
        ),
        (
            0.0 < _turn(scene) < SMALLEST,
            f"load: turns the end by about {_turn(scene):.1g}, which rounding hides; raise it",
        ),
        (
            isinstance(f, EndForce) and not any(f.force),
            "load.force: is zero and moves nothing; give a force per length, for example "
            "[0.0, 0.0, 1.0]",
        ),
        (
            isinstance(f, EndMoment) and _turn(scene) > g.path / h,
            f"load.moment: {getattr(f, 'moment', 0.0):g} bends the shell to a radius below its "
            f"thickness {h:g}; lower it",
        ),
        (
            isinstance(f, EndMoment) and f.moment == 0.0,
            "load.moment: is zero and moves nothing; give a moment per length",
        ),
    ]
    return [message for wrong, message in cases if wrong]


def _turn(scene: LoadPathScene) -> float:
    """Rotation of the loaded end by linear beam theory."""
    c, f, length = scene.structure, scene.load, scene.geometry.path
    rigidity = c.young_modulus * c.thickness**3 / 12.0
    if isinstance(f, EndForce):
        return 0.5 * math.hypot(*f.force) * length**2 / rigidity
    return abs(f.moment) * length / rigidity
