"""What scenes are made of: tables chosen by a key, sections that kinds share.

All quantities are non-dimensional: membrane stiffness, areal density and the length unit are 1,
so that time counts in L sqrt(rho_s (1-nu^2)/(E h)) and pressure in E h/((1-nu^2) L). An optional
`Physical` table gives SI values instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar, Protocol, cast

from .limits import rule, shown

SCHEMES = (
    "implicit", "semi-implicit", "auto", "iqn-ils", "aitken", "constant", "gauss-seidel",
)  # fmt: skip
STEPS = 1e7  # of a run


@dataclass(frozen=True)
class Choice:
    """A section whose keys depend on a word of the scene, so that each shape owns its table.

    Attributes
    ----------
    key : str
        The word's path, for example ``geometry.kind``.
    tables : mapping of str to type
        Section dataclass of each word; the first one is the default.
    """

    key: str
    tables: Mapping[str, type]

    @property
    def default(self) -> str:
        """The word of a scene that does not say it."""
        return next(iter(self.tables))

    def owners(self, key: str) -> list[str]:
        """Words whose tables have a key."""
        return [word for word, t in self.tables.items() if key in {f.name for f in fields(t)}]


# Section name -> its dataclass, or the tables to choose from.
Sections = Mapping[str, type | Choice]


class AnyOutput(Protocol):
    """What every kind lets a scene say about files and pictures."""

    @property
    def fields_every(self) -> int: ...
    @property
    def picture(self) -> bool: ...


class AnyScene(Protocol):
    """What scenes of all kinds have; each is a frozen dataclass of its sections."""

    kind: ClassVar[str]

    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str: ...
    @property
    def physical(self) -> Physical | None: ...
    @property
    def output(self) -> AnyOutput: ...
    @property
    def tolerances(self) -> dict[str, float]: ...


@dataclass(frozen=True)
class Time:
    """Largest step and end time; dt grows by ``step_growth``, ends the run below ``dt_floor``.

    ``dt_floor = 0`` means ``dt / 2**20``. ``error`` is the tolerated local error of a step (root
    mean square of the displacement, units of L), ``closing`` the fraction of the smallest gap a
    step may close where no contact carries load; 0 switches either off.
    """

    dt: float = rule(16.0, least=1e-9, most=1e9)
    end: float = rule(800.0, least=1e-9, most=1e9)
    step_growth: float = rule(1.5, least=1.0, most=100.0)
    dt_floor: float = rule(0.0, least=0.0, most=1e9)
    integrator: str = rule("backward-euler", choices=("backward-euler", "bdf2"))
    error: float = rule(0.0, least=0.0, most=1.0)
    closing: float = rule(0.5, least=0.0, most=1.0)

    def impossible(self) -> list[tuple[bool, str]]:
        """Combinations of single good values that cannot work together, and their messages."""
        dt, end, floor = self.dt, self.end, self.dt_floor
        return [
            (end < dt, f"time.end: {end:g} is less than one step, time.dt = {dt:g}"),
            (
                end > STEPS * dt,
                f"time.dt: {dt:g} makes {end / dt:.1g} steps until time.end = {end:g}, at most "
                f"{STEPS:.0e} are taken; raise time.dt or lower time.end",
            ),
            (floor >= dt, f"time.dt_floor: {floor:g} must be below time.dt = {dt:g}"),
        ]


class _Positive:
    """Whatever is above zero, as a container for ``only``."""

    def __contains__(self, value: float) -> bool:
        return value > 0


POSITIVE = _Positive()
WITH_FLUID = {"fluid.model": ("stokes", "potential")}
LINEAR = {"coupling.scheme": ("implicit", "semi-implicit", "auto")}
RELAXED = {"coupling.scheme": ("auto", "iqn-ils", "aitken", "constant")}
REUSING = {"kind": ("inflation",)}


@dataclass(frozen=True)
class Coupling:
    """Scheme and stopping test; ``max_iterations = 0`` is automatic (6 implicit, 30 others).

    ``dense_limit`` is the number of vector dofs up to which the implicit schemes use a dense
    fluid response, Newton-Krylov beyond; ``tolerance`` is relative to the step's increment,
    ``absolute_tolerance`` in units of L. ``reuse_tolerance``: in space, a fluid operator is
    reused while the geometry moves less than what changes the traction in the narrowest gap by
    this share of ``fluid.tolerance`` (0: never).
    """

    scheme: str = rule("implicit", choices=SCHEMES, only=WITH_FLUID)
    relaxation: float = rule(0.5, least=1e-6, most=1.0, only={**WITH_FLUID, **RELAXED})
    dense_limit: int = rule(250, least=0, most=20000, only={**WITH_FLUID, **LINEAR})
    max_iterations: int = rule(0, least=0, most=10000, only=WITH_FLUID)
    tolerance: float = rule(1e-4, least=1e-13, below=1.0, only=WITH_FLUID)
    absolute_tolerance: float = rule(1e-9, least=0.0, most=1.0, only=WITH_FLUID)
    reuse_tolerance: float = rule(0.3, least=0.0, most=1.0, only={**WITH_FLUID, **REUSING})


@dataclass(frozen=True)
class Output:
    """Steps between checkpoints and between field files (0: none), cells per element side."""

    checkpoint_every: int = rule(10, least=1, most=1000000)
    fields_every: int = rule(5, least=0, most=1000000)
    tessellate: int = rule(3, least=1, most=32)
    picture: bool = rule(True)
    seed: int = rule(0, least=0, most=2**32 - 1)


@dataclass(frozen=True)
class StepOutput:
    """Output of a kind without time: steps between field files (0: none), and the picture."""

    fields_every: int = rule(1, least=0, most=1000000)
    picture: bool = rule(True)


class TimedScene(AnyScene, Protocol):
    """What scenes of all kinds with time have besides."""

    @property
    def time(self) -> Time: ...
    @property
    def coupling(self) -> Coupling: ...
    @property
    def output(self) -> Output: ...


def without_effect(scene: AnyScene) -> list[str]:
    """Keys that differ from their defaults and have no effect in this scene, with the reason."""
    found = []
    for section in fields(scene):  # type: ignore[arg-type]
        part = getattr(scene, section.name)
        for key in fields(part) if is_dataclass(part) else ():
            path, value = f"{section.name}.{key.name}", getattr(part, key.name)
            if value == key.default or (scene.physical and path in DETERMINED):
                continue
            for other, needed in key.metadata.get("only", {}).items():
                if (actual := _at(scene, other)) not in needed:
                    found.append(
                        f"{path} = {shown(value)} has no effect with {other} = {shown(actual)}; "
                        "leave it out"
                    )
                    break
    return found


def unusual(scene: AnyScene) -> str:
    """The number of a scene that is farthest from its default, most likely the one in error."""
    worst, found = 0.0, "the values that differ from their defaults"
    for section in fields(scene):  # type: ignore[arg-type]
        part = getattr(scene, section.name)
        for key in fields(part) if is_dataclass(part) else ():
            value, usual = getattr(part, key.name), cast(Any, key.default)
            if all(isinstance(v, int | float) and v > 0 for v in (value, usual)):
                distance = abs(math.log(value / usual))
                if distance > worst:
                    worst = distance
                    found = f"{section.name}.{key.name} = {value:g} (default {usual:g})"
    return found


def _at(scene: Any, path: str) -> Any:
    for name in path.split("."):
        scene = getattr(scene, name)
    return scene


@dataclass(frozen=True)
class Physical:
    """SI values: m, m, Pa, -, kg/m^2, Pa s; they determine the groups in `DETERMINED`."""

    length: float = rule(math.nan, least=1e-9, most=1e6)
    thickness: float = rule(math.nan, least=1e-12, most=1e3)
    young_modulus: float = rule(math.nan, least=1.0, most=1e15)
    areal_density: float = rule(math.nan, least=1e-9, most=1e9)
    viscosity: float = rule(math.nan, least=1e-9, most=1e12)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)

    @property
    def stiffness(self) -> float:
        """Membrane stiffness E h / (1 - nu^2) in N/m."""
        return self.young_modulus * self.thickness / (1.0 - self.poisson_ratio**2)

    @property
    def time_unit(self) -> float:
        """Seconds in one unit of time."""
        return self.length * math.sqrt(self.areal_density / self.stiffness)

    @property
    def pressure_unit(self) -> float:
        """Pascals in one unit of pressure."""
        return self.stiffness / self.length

    def groups(self) -> dict[str, float]:
        """Dimensionless keys of a scene that follow from these values."""
        return {
            "structure.stiffness": 1.0,
            "structure.density": 1.0,
            "structure.poisson_ratio": self.poisson_ratio,
            "structure.flexural_rigidity": (self.thickness / self.length) ** 2 / 12.0,
            "fluid.mass_ratio": self.viscosity / (self.pressure_unit * self.time_unit),
        }


# Dimensionless key -> the key of [physical] that speaks about it.
DETERMINED: Mapping[str, str] = {
    "structure.stiffness": "physical.young_modulus",
    "structure.density": "physical.areal_density",
    "structure.poisson_ratio": "physical.poisson_ratio",
    "structure.flexural_rigidity": "physical.thickness",
    "fluid.mass_ratio": "physical.viscosity",
}


class SceneError(ValueError):
    """A scene that cannot be used.

    Attributes
    ----------
    errors : list of str
        Every problem found, each with the key's full path.
    """

    def __init__(self, errors: Sequence[str]):
        self.errors = list(errors)
        super().__init__("\n".join(self.errors))
