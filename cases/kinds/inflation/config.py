"""An inflation as frozen dataclasses: fields with their units, defaults and admissible ranges.

Units as in `cases.sections`; the fluid enters by m = varpi/Re.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from ...sections import Choice, Coupling, Output, Physical, Sections, Time, rule

FOLDS = ("flat", "accordion", "roll", "double")


@dataclass(frozen=True)
class PancakeGeometry:
    """A round bag with a neck: lengths in units of L, ``radius`` is half the sheets' distance."""

    kind: str = rule("pancake", choices=("pancake",))
    radius: float = rule(1.0, above=0.0)
    half_width: float = rule(10.0, above=0.0)
    neck_radius: float = rule(1.0, above=0.0)
    fillet: float = rule(1.0, above=0.0)


@dataclass(frozen=True)
class PillowGeometry:
    """A bag of unit length, ``width`` across, flat, folded or rolled.

    It is folded ``folds`` times (``folds_across`` times more in the other direction) or rolled
    ``turns`` times; ``panel``, ``gap`` (distance of the sheets) and ``pitch`` of a roll in fold
    radii, the gap of a flat bag in units of L; ``crumple`` is the amplitude of a random
    collision-free displacement after folding.
    """

    kind: str = rule("pillow", choices=("pillow",))
    plan: str = rule("rectangle", choices=("rectangle", "round"))
    width: float = rule(1.0, above=0.0)
    fold: str = rule("flat", choices=FOLDS)
    folds: int = rule(2, least=1)
    folds_across: int = rule(1, least=1)
    turns: float = rule(2.0, above=0.0)
    pitch: float = rule(1.0, above=0.0)
    panel: float = rule(10.0, above=0.0)
    gap: float = rule(0.4, above=0.0)
    crumple: float = rule(0.0, least=0.0, most=1.0)


@dataclass(frozen=True)
class PancakeMesh:
    """Spline degree, elements in a ring, rows on rim, fillet and inflow disc, element sizes.

    ``flat_max`` is the largest element on the sheets, ``pole`` the size of the one at the pole;
    ``joints = "double"`` doubles knots where lines meet arcs (curvature may jump there).
    """

    degree: int = rule(3, choices=(2, 3))
    around: int = rule(12, least=4)
    rim: int = rule(4, least=1)
    fillet: int = rule(2, least=1)
    flat_max: float = rule(3.0, above=0.0)
    pole: float = rule(2.0, above=0.0)
    disc: int = rule(2, least=1)
    joints: str = rule("smooth", choices=("smooth", "double"))


@dataclass(frozen=True)
class PillowMesh:
    """``around`` elements around, ``across`` between the zipped ends (0: half as many).

    All of degree 2, as the corner conditions are those of biquadratic splines; ``inlet`` elements
    along a side of the inlet.
    """

    degree: int = rule(2, choices=(2,))
    around: int = rule(24, least=12)
    across: int = rule(0, least=0)
    inlet: int = rule(2, least=2)


@dataclass(frozen=True)
class BagStructure:
    """Membrane: stiffness 1 and density 1 define the units; rigidity is (h/L)^2 / 12.

    ``quadrature`` counts Gauss points per direction; 0 means degree + 1. ``membrane`` chooses the
    points of the membrane energy: ``"reduced"`` is the rule of fewer points that does not lock.
    ``reference`` names the stress-free state of a folded bag: ``folded`` takes the metric of the
    folded state and the curvature of the flat bag, ``flat`` both from the flat bag, ``creased``
    both from the folded state (only pressure opens it).
    """

    stiffness: float = rule(1.0, above=0.0)
    density: float = rule(1.0, above=0.0)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)
    flexural_rigidity: float = rule(1e-2, above=0.0)
    inflow_rim: str = rule("clamped", choices=("hinged", "clamped"))
    quadrature: int = rule(0, least=0, most=12)
    membrane: str = rule("gauss", choices=("gauss", "reduced"))
    reference: str = rule("folded", choices=("folded", "flat", "creased"))


@dataclass(frozen=True)
class BagFluid:
    """Stokes flow inside and outside, or a uniform pressure without any flow.

    ``mass_ratio`` is m = varpi/Re, ``tolerance`` the relative traction error, ``outer_points``
    Gauss points per direction of the outer integral, ``polar`` radial and angular points of the
    self rule, ``near_ball`` the reach of the near rule in element radii. ``polar = [0, 0]`` and
    ``krylov_tolerance = 0`` follow from ``tolerance`` and the narrowest gap. ``compression`` of
    the single layer: ``auto`` takes the cheapest, ``dense`` stores it or sums it directly.
    """

    model: str = rule("stokes", choices=("stokes", "pressure"))
    viscosity_ratio: float = rule(1.0, above=0.0)
    mass_ratio: float = rule(0.005, above=0.0)
    tolerance: float = rule(1e-3, above=0.0, below=1.0)
    outer_points: int = rule(3, choices=(2, 3, 4))
    polar: tuple[int, int] = rule((0, 0), least=0)
    near_ball: float = rule(1.0, above=0.0)
    solver: str = rule("auto", choices=("auto", "lu", "gmres"))
    compression: str = rule("auto", choices=("auto", "dense", "aca", "h2"))
    krylov_tolerance: float = rule(0.0, least=0.0, below=1.0)
    krylov_iterations: int = rule(500, least=1)


@dataclass(frozen=True)
class BagInflow:
    """Influx rises over t1, is constant until t2 and ends at t1 + t2; volume as multiple of V0."""

    final_volume: float = rule(3.0, above=0.0)
    t1: float = rule(200.0, above=0.0)
    t2: float = rule(400.0, above=0.0)


@dataclass(frozen=True)
class ContactTest:
    """Test of configurations for self-intersection, on ``tessellate`` cells a side.

    ``test`` "auto" starts at once in a folded bag, elsewhere as soon as contact is possible.
    """

    test: str = rule("auto", choices=("auto", "on", "off"))
    tessellate: int = rule(3, least=1, most=16)


@dataclass(frozen=True)
class InflationScene:
    """Everything an inflation is made of; see `cases.loader` for the way from TOML."""

    kind: ClassVar[str] = "inflation"

    name: str
    description: str = ""
    geometry: PancakeGeometry | PillowGeometry = PancakeGeometry()
    mesh: PancakeMesh | PillowMesh = PancakeMesh()
    structure: BagStructure = BagStructure()
    fluid: BagFluid = BagFluid()
    inflow: BagInflow = BagInflow()
    time: Time = field(default_factory=Time)
    coupling: Coupling = field(default_factory=Coupling)
    contact: ContactTest = ContactTest()
    output: Output = field(default_factory=Output)
    physical: Physical | None = None

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {
            "fluid.tolerance": self.fluid.tolerance,
            "fluid.krylov_tolerance": self.fluid.krylov_tolerance,
            "coupling.tolerance": self.coupling.tolerance,
            "coupling.absolute_tolerance": self.coupling.absolute_tolerance,
        }


SECTIONS: Sections = {
    "geometry": Choice("geometry.kind", {"pancake": PancakeGeometry, "pillow": PillowGeometry}),
    "mesh": Choice("geometry.kind", {"pancake": PancakeMesh, "pillow": PillowMesh}),
    "structure": BagStructure,
    "fluid": BagFluid,
    "inflow": BagInflow,
    "time": Time,
    "coupling": Coupling,
    "contact": ContactTest,
    "output": Output,
    "physical": Physical,
}


def impossible(scene: InflationScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    g, m = scene.geometry, scene.mesh
    cases = [
        (
            tuple(scene.fluid.polar) != (0, 0) and min(scene.fluid.polar) < 2,
            f"fluid.polar: {list(scene.fluid.polar)} must be at least 2, or [0, 0] for automatic",
        ),
        (
            scene.fluid.compression == "aca" and scene.fluid.outer_points < 3,
            "fluid.compression: 'aca' needs equal outer and source points; set "
            "fluid.outer_points = 3, or use 'h2'",
        ),
        (
            scene.fluid.compression in ("aca", "h2") and scene.fluid.solver == "lu",
            f"fluid.solver: 'lu' needs the dense matrix, fluid.compression = "
            f"{scene.fluid.compression!r} has none; use 'gmres' or 'auto'",
        ),
        (
            scene.inflow.t2 < scene.inflow.t1,
            f"inflow.t2: {scene.inflow.t2:g} lies before the end of the ramp, "
            f"inflow.t1 = {scene.inflow.t1:g}",
        ),
        *scene.time.impossible(),
    ]
    if isinstance(g, PancakeGeometry) and isinstance(m, PancakeMesh):
        cases = [*_impossible_pancake(g, m), *cases]
    if isinstance(g, PillowGeometry) and isinstance(m, PillowMesh):
        cases = [*cases, *_impossible_folds(g, m)]
    return [message for wrong, message in cases if wrong]


def _impossible_pancake(g: PancakeGeometry, m: PancakeMesh) -> list[tuple[bool, str]]:
    needed = g.radius + g.neck_radius + g.fillet
    return [
        (
            g.half_width <= needed,
            f"geometry.half_width: {g.half_width:g} leaves no lower sheet; it must exceed "
            f"radius + neck_radius + fillet = {needed:g}",
        ),
        (
            m.joints == "double" and m.degree == 2,
            "mesh.joints: 'double' knots on degree 2 break the tangent; use mesh.degree = 3",
        ),
    ]


def _impossible_folds(g: PillowGeometry, m: PillowMesh) -> list[tuple[bool, str]]:
    """Foldings that cannot be: sheets inside out, panels too short, a basis too small."""
    folded, zigzag = g.fold != "flat", g.fold in ("accordion", "double")
    closest = g.pitch if g.fold == "roll" else 2.0
    across = m.across or m.around // 2
    return [
        (
            folded and g.gap >= closest,
            f"geometry.gap: {g.gap:g} fold radii: neighbouring panels would touch or sheets turn "
            f"inside out; it must be below {closest:g}",
        ),
        (
            not folded and g.gap >= 1.0,
            f"geometry.gap: {g.gap:g} of the length is no flat bag; use less than 1",
        ),
        (
            zigzag and g.panel <= math.pi,
            f"geometry.panel: {g.panel:g} fold radii leave no room for the folds; it must exceed "
            "pi fold radii (6 or 10 are usual)",
        ),
        (
            g.fold == "double" and g.panel > math.pi and not _pack_fits(g),
            f"geometry.folds_across: {g.folds_across} folds of the pack need more width than there "
            "is; fold less, or raise geometry.panel",
        ),
        (
            m.around % 2 == 1 or across < 6,
            f"mesh.around: a pillow needs an even number of at least 12 elements around and 6 "
            f"across, not {m.around} x {across}",
        ),
        (
            m.inlet > across // 3,
            f"mesh.inlet: {m.inlet} elements are too many for {across} across; use at most "
            f"{across // 3}",
        ),
    ]


def _pack_fits(g: PillowGeometry) -> bool:
    """Whether the second folds of a pack leave straight panels between them."""
    from ...geometry.folding import pack_radius

    radius = pack_radius(g.folds, g.panel, g.gap)
    return math.pi * radius * (g.folds_across + 1) < 1.0
