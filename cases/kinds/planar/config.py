"""A planar scene as frozen dataclasses: fields with their defaults and admissible ranges.

Non-dimensional as `cases.sections` says: stiffness, line density and length unit are 1; the
thesis' planar Kirchhoff-Love law [T 2.21] is that of ``structure.stiffness = 2``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from ...limits import rule
from ...sections import POSITIVE, WITH_FLUID, Choice, Coupling, Output, Sections, Time

LENGTH = {"least": 1e-4, "most": 1e4}
STOKES, POTENTIAL = {"fluid.model": ("stokes",)}, {"fluid.model": ("potential",)}
THINNEST = 1e-5  # gap over extent: beyond it rounding shows in the load
FLATNESS = 9.5  # width over depth of the folded bag
PARTITIONED = ("iqn-ils", "aitken", "constant", "gauss-seidel")
GRADED = {"mesh.uniform": (0,)}


@dataclass(frozen=True)
class _Curve:
    """What all shapes over a straight inlet have.

    ``radius``: half the distance of the sheets, or of the circle. ``inlet``: width of the inlet
    (0: ``radius``). ``asymmetry``: amplitude of a sideways disturbance, which decides what
    rounding would.
    """

    kind: str = ""
    radius: float = rule(1.0 / 3.0, **LENGTH)
    inlet: float = rule(0.0, least=0.0, most=1e4)
    asymmetry: float = rule(0.0, least=-1e3, most=1e3)


@dataclass(frozen=True)
class FlatCurve(_Curve):
    """Two sheets with round ends, ``width`` wide [T fig. 4.2]."""

    kind: str = rule("pancake", choices=("pancake",))
    width: float = rule(20.0, **LENGTH)


@dataclass(frozen=True)
class ArcCurve(_Curve):
    """Part of a circle [T 5.3.2]."""

    kind: str = rule("arc", choices=("arc",))


@dataclass(frozen=True)
class FoldCurve(_Curve):
    """A folded bag; radius and panel of the folds' mid-curve, half length of the chamber.

    0 stands for 5 radii, 10 fold radii and the chamber of the thesis' flatness.
    """

    kind: str = rule("fold", choices=("fold",))
    fold_radius: float = rule(0.0, least=0.0, most=1e4)
    panel: float = rule(0.0, least=0.0, most=1e4)
    chamber: float = rule(0.0, least=0.0, most=1e4)

    @property
    def sizes(self) -> tuple[float, float, float, float]:
        """Half gap, fold radius, panel and half chamber."""
        r = self.radius
        rho = self.fold_radius or 5.0 * r
        panel = self.panel or 10.0 * rho
        depth = 4.0 * rho + 3.0 * r  # from the inlet's plane to the outer sheet
        chamber = self.chamber or 0.5 * FLATNESS * depth - rho - r
        return r, rho, panel, chamber


PlanarShape = FlatCurve | ArcCurve | FoldCurve


@dataclass(frozen=True)
class PlanarMesh:
    """Largest elements on straight and on curved pieces, elements of the inlet (even).

    ``uniform``: equal elements of the whole membrane instead, so many (0: none). ``halvings``: of
    every element of the membrane, for nested meshes.
    """

    straight: float = rule(0.4, **LENGTH, only=GRADED)
    curved: float = rule(0.2, **LENGTH, only=GRADED)
    inlet: int = rule(2, least=2, most=64)
    uniform: int = rule(0, least=0, most=4096)
    halvings: int = rule(0, least=0, most=8)


@dataclass(frozen=True)
class PlanarStructure:
    """Membrane: law, stiffness, rigidity, how its ends are held at the inlet."""

    law: str = rule("kirchhoff-love", choices=("kirchhoff-love", "string"))
    stiffness: float = rule(2.0, least=1e-6, most=1e6)
    density: float = rule(1.0, least=1e-9, most=1e9)
    flexural_rigidity: float = rule(1e-4, least=1e-14, most=100.0)
    ends: str = rule("hinged", choices=("hinged", "clamped"))


@dataclass(frozen=True)
class PlanarFluid:
    """Stokes or potential flow, or a uniform pressure.

    ``mass_ratio``: m = varpi/Re for Stokes, varpi for potential flow. ``viscosity_ratio``: 0 leaves
    the exterior out. ``log_radius``: where the exterior flow vanishes (Stokes' paradox), s in
    log(s/r). ``near_points``: of the graded outer rule, 0 for plain Gauss. ``contact_force`` (0:
    none) and ``contact_cutoff`` belong to potential flow [T 4.14].
    """

    model: str = rule("stokes", choices=("stokes", "potential", "pressure"))
    mass_ratio: float = rule(0.005, least=1e-12, most=1e12, only=WITH_FLUID)
    viscosity_ratio: float = rule(1.0, least=0.0, most=1e6, only=STOKES)
    log_radius: float = rule(100.0, least=1e-3, most=1e12, only=STOKES)
    outer_points: int = rule(6, least=2, most=16, only=WITH_FLUID)
    near_points: int = rule(16, least=0, most=40, only=WITH_FLUID)
    contact_force: float = rule(0.0, least=0.0, most=1e6, only=POTENTIAL)
    contact_cutoff: float = rule(2.0, **LENGTH, only={"fluid.contact_force": POSITIVE})


@dataclass(frozen=True)
class PlanarInflow:
    """Influx rises over t1, is constant until t2 and ends at t1 + t2 [T 4.30c].

    ``final_volume`` is a multiple of the initial one; 0 takes ``fullness`` times the area of the
    circle with the boundary's length, 1.05 in the thesis.
    """

    final_volume: float = rule(0.0, least=0.0, most=1e3)
    fullness: float = rule(1.05, least=1e-2, most=100.0, only={"inflow.final_volume": (0.0,)})
    t1: float = rule(100.0, least=1e-6, most=1e9)
    t2: float = rule(200.0, least=1e-6, most=1e9)


@dataclass(frozen=True)
class PotentialCoupling(Coupling):
    """As `Coupling`: the load of potential flow is quadratic, so its scheme is partitioned."""

    scheme: str = rule(
        "iqn-ils",
        choices=PARTITIONED,
        why="the load of potential flow is quadratic in the velocity, the others need a linear one",
    )


@dataclass(frozen=True)
class PlanarScene:
    """Everything a planar run is made of."""

    kind: ClassVar[str] = "planar"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    geometry: PlanarShape = FlatCurve()
    mesh: PlanarMesh = PlanarMesh()
    structure: PlanarStructure = PlanarStructure()
    fluid: PlanarFluid = PlanarFluid()
    inflow: PlanarInflow = PlanarInflow()
    time: Time = field(default_factory=lambda: Time(dt=1.0, end=400.0))
    coupling: Coupling = field(default_factory=Coupling)
    output: Output = field(default_factory=Output)

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {
            "coupling.tolerance": self.coupling.tolerance,
            "coupling.absolute_tolerance": self.coupling.absolute_tolerance,
        }


SECTIONS: Sections = {
    "geometry": Choice("geometry.kind", {"pancake": FlatCurve, "arc": ArcCurve, "fold": FoldCurve}),
    "mesh": PlanarMesh,
    "structure": PlanarStructure,
    "fluid": PlanarFluid,
    "inflow": PlanarInflow,
    "time": Time,
    "coupling": Choice(
        "fluid.model",
        {"stokes": Coupling, "potential": PotentialCoupling, "pressure": Coupling},
    ),
    "output": Output,
}


def impossible(scene: PlanarScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    g, f = scene.geometry, scene.fluid
    cases: list[tuple[bool, str]] = [
        *_impossible_shape(g),
        (
            0.0 < g.inlet < 1e-4,
            f"geometry.inlet: {g.inlet:g} must be 0 (the radius) or at least 0.0001",
        ),
        (
            0.0 < f.viscosity_ratio < 1e-6,
            f"fluid.viscosity_ratio: {f.viscosity_ratio:g} must be 0 (no exterior) or at least "
            "1e-6",
        ),
        (
            scene.mesh.inlet % 2 == 1,
            f"mesh.inlet: {scene.mesh.inlet} must be even: one node at the profile's peak",
        ),
        (
            f.contact_force > 0.0 and f.model != "potential",
            "fluid.contact_force: belongs to fluid.model = 'potential'; Stokes flow lubricates",
        ),
        (
            scene.inflow.t2 < scene.inflow.t1,
            f"inflow.t2: {scene.inflow.t2:g} lies before the end of the ramp, "
            f"inflow.t1 = {scene.inflow.t1:g}",
        ),
        *scene.time.impossible(),
        (
            not math.isfinite(g.asymmetry) or abs(g.asymmetry) > 0.1 * g.radius,
            f"geometry.asymmetry: {g.asymmetry:g} must stay below a tenth of the radius",
        ),
    ]
    return [message for wrong, message in cases if wrong]


def _impossible_shape(g: PlanarShape) -> list[tuple[bool, str]]:
    inlet = g.inlet or g.radius
    if isinstance(g, FlatCurve):
        return [
            (
                g.radius < THINNEST * g.width,
                f"geometry.radius: {g.radius:g} is below {THINNEST:g} of width = {g.width:g}: "
                "rounding hides the flow in such a gap; raise it",
            ),
            (
                g.width <= 4.0 * g.radius + inlet,
                f"geometry.width: {g.width:g} leaves no lower sheet; it must exceed 4 radius + "
                f"inlet = {4.0 * g.radius + inlet:g}",
            ),
        ]
    if isinstance(g, ArcCurve):
        return [
            (
                inlet >= 2.0 * g.radius,
                f"geometry.inlet: {inlet:g} must be below the diameter {2.0 * g.radius:g}",
            )
        ]
    r, rho, panel, chamber = g.sizes
    return [
        (
            chamber <= 0.5 * inlet + r,
            f"geometry.chamber: {chamber:g} is no longer than half the inlet and the radius, "
            f"{0.5 * inlet + r:g}; raise it or lower geometry.inlet",
        ),
        (
            0.0 < g.fold_radius <= g.radius,
            f"geometry.fold_radius: {g.fold_radius:g} must exceed half the gap, {g.radius:g}",
        ),
        (
            r < THINNEST * max(panel, rho, chamber),
            f"geometry.radius: {g.radius:g} is below {THINNEST:g} of the folds: rounding hides the "
            "flow in such a gap; raise it",
        ),
    ]
