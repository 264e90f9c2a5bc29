"""What scenes are made of: fields with limits, tables chosen by a key, sections that kinds share.

All quantities are non-dimensional: membrane stiffness, areal density and the length unit are 1,
so that time counts in L sqrt(rho_s (1-nu^2)/(E h)) and pressure in E h/((1-nu^2) L). An optional
`Physical` table gives SI values instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Protocol

SCHEMES = (
    "implicit", "semi-implicit", "auto", "iqn-ils", "aitken", "constant", "gauss-seidel",
)  # fmt: skip


def rule(default: Any, **limits: Any) -> Any:
    """Field with a default and limits: ``above, least, below, most, choices``."""
    return field(default=default, metadata=limits)


def out_of_range(path: str, value: Any, limits: Mapping[str, Any]) -> list[str]:
    """What is wrong with a value of the right type, one message or none."""
    values = value if isinstance(value, tuple) else (value,)
    choices = limits.get("choices")
    if choices is not None:
        wrong = value not in choices
        return [f"{path}: {value!r} is none of {', '.join(map(repr, choices))}"] if wrong else []
    tests = {
        "above": (lambda v, x: v > x, "above"),
        "least": (lambda v, x: v >= x, "at least"),
        "below": (lambda v, x: v < x, "below"),
        "most": (lambda v, x: v <= x, "at most"),
    }
    shown = list(value) if isinstance(value, tuple) else value
    return [
        f"{path}: {shown!r} must be {words} {limits[key]:g}"
        for key, (test, words) in tests.items()
        if key in limits and not all(test(v, limits[key]) for v in values)
    ]


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
    step may close; 0 switches either off.
    """

    dt: float = rule(16.0, above=0.0)
    end: float = rule(800.0, above=0.0)
    step_growth: float = rule(1.5, least=1.0)
    dt_floor: float = rule(0.0, least=0.0)
    integrator: str = rule("backward-euler", choices=("backward-euler", "bdf2"))
    error: float = rule(0.0, least=0.0)
    closing: float = rule(0.5, least=0.0)

    def impossible(self) -> list[tuple[bool, str]]:
        """Combinations of single good values that cannot work together, and their messages."""
        dt, end, floor = self.dt, self.end, self.dt_floor
        return [
            (end < dt, f"time.end: {end:g} is less than one step, time.dt = {dt:g}"),
            (floor >= dt, f"time.dt_floor: {floor:g} must be below time.dt = {dt:g}"),
        ]


@dataclass(frozen=True)
class Coupling:
    """Scheme and stopping test; ``max_iterations = 0`` is automatic (6 implicit, 30 others).

    ``dense_limit`` is the number of vector dofs up to which the implicit schemes use a dense
    fluid response, Newton-Krylov beyond; ``tolerance`` is relative to the step's increment,
    ``absolute_tolerance`` in units of L. ``reuse_tolerance``: in space, a fluid operator is
    reused while the geometry moves less than what changes the traction in the narrowest gap by
    this share of ``fluid.tolerance`` (0: never).
    """

    scheme: str = rule("implicit", choices=SCHEMES)
    relaxation: float = rule(0.5, above=0.0, most=1.0)
    dense_limit: int = rule(4000, least=0)
    max_iterations: int = rule(0, least=0)
    tolerance: float = rule(1e-4, above=0.0, below=1.0)
    absolute_tolerance: float = rule(1e-9, least=0.0)
    reuse_tolerance: float = rule(0.3, least=0.0, most=1.0)


@dataclass(frozen=True)
class Output:
    """Steps between checkpoints and between field files (0: none), cells per element side."""

    checkpoint_every: int = rule(10, least=1)
    fields_every: int = rule(5, least=0)
    tessellate: int = rule(3, least=1, most=32)
    picture: bool = rule(True)
    seed: int = rule(0, least=0)


@dataclass(frozen=True)
class StepOutput:
    """Output of a kind without time: steps between field files (0: none), and the picture."""

    fields_every: int = rule(1, least=0)
    picture: bool = rule(True)


class TimedScene(AnyScene, Protocol):
    """What scenes of all kinds with time have besides."""

    @property
    def time(self) -> Time: ...
    @property
    def coupling(self) -> Coupling: ...
    @property
    def output(self) -> Output: ...


@dataclass(frozen=True)
class Physical:
    """SI values: m, m, Pa, -, kg/m^2, Pa s; they determine the groups in `DETERMINED`."""

    length: float = rule(math.nan, above=0.0)
    thickness: float = rule(math.nan, above=0.0)
    young_modulus: float = rule(math.nan, above=0.0)
    areal_density: float = rule(math.nan, above=0.0)
    viscosity: float = rule(math.nan, above=0.0)
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
