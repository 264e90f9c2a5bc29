"""An inflation as frozen dataclasses: fields with their units, defaults and admissible ranges.

Units as in `cases.sections`; the fluid enters by m = varpi/Re.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from ...limits import rule
from ...sections import Choice, Coupling, Output, Physical, Sections, Time
from .mesh_config import MeshGeometry, TriangleMesh

FOLDS = ("flat", "accordion", "roll", "double")
LENGTH = {"least": 1e-4, "most": 1e4}
RATIO = {"least": 1e-6, "most": 1e6}
TIME = {"least": 1e-6, "most": 1e9}
WRINKLES = {"structure.law": ("tension-field",)}
PILLOW = {"geometry.kind": ("pillow",)}
UNFOLDS = {"geometry.kind": ("pillow", "mesh")}
FLOW = {"fluid.model": ("stokes",)}
CARRIED = {"contact.force": ("barrier",)}
ITERATIVE = {**FLOW, "fluid.solver": ("auto", "gmres")}


def _folded(*words: str) -> dict[str, tuple[str, ...]]:
    """Condition of keys that belong to some foldings."""
    return {"geometry.fold": words}


@dataclass(frozen=True)
class PancakeGeometry:
    """A round bag with a neck: lengths in units of L, ``radius`` is half the sheets' distance."""

    kind: str = rule("pancake", choices=("pancake",))
    radius: float = rule(1.0, **LENGTH)
    half_width: float = rule(10.0, **LENGTH)
    neck_radius: float = rule(1.0, **LENGTH)
    fillet: float = rule(1.0, **LENGTH)


@dataclass(frozen=True)
class PillowGeometry:
    """A bag of unit length, ``width`` across, flat, folded or rolled.

    A ``rectangle`` has round corners, a ``square`` is exactly one.

    It is folded ``folds`` times (``folds_across`` times more in the other direction) or rolled
    ``turns`` times; ``panel``, ``gap`` (distance of the sheets) and ``pitch`` of a roll in fold
    radii, the gap of a flat bag in units of L; ``crumple`` is the amplitude of a random
    collision-free displacement after folding.
    """

    kind: str = rule("pillow", choices=("pillow",))
    plan: str = rule("rectangle", choices=("rectangle", "round", "square"))
    width: float = rule(1.0, least=0.01, most=100.0, only={"geometry.plan": ("rectangle",)})
    fold: str = rule("flat", choices=FOLDS)
    folds: int = rule(2, least=1, most=256, only=_folded("accordion", "double"))
    folds_across: int = rule(1, least=1, most=64, only=_folded("double"))
    turns: float = rule(2.0, least=0.1, most=64.0, only=_folded("roll"))
    pitch: float = rule(1.0, least=1e-4, most=1e3, only=_folded("roll"))
    panel: float = rule(10.0, least=1e-2, most=1e4, only=_folded("accordion", "double"))
    gap: float = rule(0.4, least=1e-5, most=1e3)
    crumple: float = rule(0.0, least=0.0, most=1.0)


@dataclass(frozen=True)
class PancakeMesh:
    """Spline degree, elements in a ring, rows on rim, fillet and inflow disc, element sizes.

    ``flat_max`` is the largest element on the sheets, ``pole`` the size of the one at the pole;
    ``joints = "double"`` doubles knots where lines meet arcs (curvature may jump there).
    """

    degree: int = rule(3, choices=(2, 3))
    around: int = rule(12, least=4, most=4096)
    rim: int = rule(4, least=1, most=1024)
    fillet: int = rule(2, least=1, most=1024)
    flat_max: float = rule(3.0, **LENGTH)
    pole: float = rule(2.0, **LENGTH)
    disc: int = rule(2, least=1, most=1024)
    joints: str = rule("smooth", choices=("smooth", "double"))


@dataclass(frozen=True)
class PillowMesh:
    """``around`` elements around, ``across`` between the zipped ends (0: half as many).

    All of degree 2, as the corner conditions are those of biquadratic splines; ``inlet`` elements
    along a side of the inlet.
    """

    degree: int = rule(2, choices=(2,))
    around: int = rule(24, least=12, most=4096)
    across: int = rule(0, least=0, most=4096)
    inlet: int = rule(2, least=2, most=1024)


@dataclass(frozen=True)
class BagStructure:
    """Membrane: stiffness 1 and density 1 define the units; rigidity is (h/L)^2 / 12.

    ``quadrature`` counts Gauss points per direction; 0 means degree + 1. ``membrane`` chooses the
    points of the membrane energy: ``"reduced"`` is the rule of fewer points that does not lock.
    ``reference`` names the stress-free state of a folded bag: ``folded`` takes the metric of the
    folded state and the curvature of the flat bag, ``flat`` both from the flat bag, ``creased``
    both from the folded state (only pressure opens it); ``auto`` is ``flat`` where a mesh file
    brings an unfolded bag, else ``folded``.

    ``law = "tension-field"`` lets the membrane wrinkle without resistance, but for the share
    ``compression_share`` of its stiffness; only then may the rigidity be below 1e-14, or 0.
    ``seam = "hinged"``: no bending in the elements along the rim of a pillow, where its sheets
    are sewn together; ``"continuous"`` bends about the rim as the flat bag is bent there. In a
    mesh its sharp edges (``geometry.crease``) are the seams.
    """

    stiffness: float = rule(1.0, **RATIO)
    density: float = rule(1.0, least=1e-9, most=1e9)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)
    flexural_rigidity: float = rule(1e-2, least=0.0, most=100.0)
    law: str = rule("svk", choices=("svk", "tension-field"))
    compression_share: float = rule(1e-3, least=0.0, below=1.0, only=WRINKLES)
    inflow_rim: str = rule("clamped", choices=("hinged", "clamped"))
    quadrature: int = rule(0, least=0, most=12)
    membrane: str = rule("gauss", choices=("gauss", "reduced"))
    reference: str = rule("auto", choices=("auto", "folded", "flat", "creased"), only=UNFOLDS)
    seam: str = rule("continuous", choices=("continuous", "hinged"), only=UNFOLDS)

    @property
    def kept_compression(self) -> float:
        """Share of its stiffness that the membrane keeps against compression."""
        return self.compression_share if self.law == "tension-field" else 1.0


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
    viscosity_ratio: float = rule(1.0, **RATIO, only=FLOW)
    mass_ratio: float = rule(0.005, least=1e-12, most=1e12, only=FLOW)
    tolerance: float = rule(1e-3, least=1e-10, below=1.0, only=FLOW)
    outer_points: int = rule(3, choices=(2, 3, 4), only=FLOW)
    polar: tuple[int, int] = rule((0, 0), least=0, most=24, only=FLOW)
    near_ball: float = rule(1.0, least=0.1, most=10.0, only=FLOW)
    solver: str = rule("auto", choices=("auto", "lu", "gmres"), only=FLOW)
    compression: str = rule("auto", choices=("auto", "dense", "aca", "h2"), only=FLOW)
    krylov_tolerance: float = rule(0.0, least=0.0, below=1.0, only=ITERATIVE)
    krylov_iterations: int = rule(500, least=1, most=100000, only=ITERATIVE)


@dataclass(frozen=True)
class BagInflow:
    """Influx rises over t1, is constant until t2 and ends at t1 + t2; volume as multiple of V0."""

    final_volume: float = rule(3.0, least=1e-3, most=1e3)
    t1: float = rule(200.0, **TIME)
    t2: float = rule(400.0, **TIME)


@dataclass(frozen=True)
class BagContact:
    """Contact of the bag with itself: forces that keep sheets apart, and a test of motions.

    ``force`` "barrier" acts from a distance of ``reach`` smallest gaps on (0: 0.15, or 0.1 where
    sheets are that near at rest), in a folded bag always and elsewhere while contact is possible;
    ``stiffness`` is the pressure that it is measured by (0: four times the largest one forecast).
    ``test`` on ``tessellate`` cells a side "auto" starts like the force. With forces it asks that
    nothing crosses, without that nothing touches.
    """

    force: str = rule("barrier", choices=("barrier", "none"))
    reach: float = rule(0.0, least=0.0, most=1.0, only=CARRIED)
    stiffness: float = rule(0.0, least=0.0, most=1e3, only=CARRIED)
    test: str = rule("auto", choices=("auto", "on", "off"))
    tessellate: int = rule(3, least=1, most=16)


@dataclass(frozen=True)
class InflationScene:
    """Everything an inflation is made of; see `cases.loader` for the way from TOML."""

    kind: ClassVar[str] = "inflation"

    name: str
    description: str = ""
    geometry: PancakeGeometry | PillowGeometry | MeshGeometry = PancakeGeometry()
    mesh: PancakeMesh | PillowMesh | TriangleMesh = PancakeMesh()
    structure: BagStructure = BagStructure()
    fluid: BagFluid = BagFluid()
    inflow: BagInflow = BagInflow()
    time: Time = field(default_factory=Time)
    coupling: Coupling = field(default_factory=Coupling)
    contact: BagContact = BagContact()
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
    "geometry": Choice(
        "geometry.kind",
        {"pancake": PancakeGeometry, "pillow": PillowGeometry, "mesh": MeshGeometry},
    ),
    "mesh": Choice(
        "geometry.kind", {"pancake": PancakeMesh, "pillow": PillowMesh, "mesh": TriangleMesh}
    ),
    "structure": BagStructure,
    "fluid": BagFluid,
    "inflow": BagInflow,
    "time": Time,
    "coupling": Coupling,
    "contact": BagContact,
    "output": Output,
    "physical": Physical,
}
