"""A capsule scene as frozen dataclasses: a closed elastic membrane in a linear flow.

Units as in `cases.sections`, the radius of the sphere of equal volume is the length unit. The flow
is ``u = gdot G x`` with G of `GRADIENTS` and ``gdot = Ca Gs / (lambda m)``: Ca counts the outer
viscosity against the membrane's shear modulus ``Gs = (1 - nu) / 2``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...limits import rule
from ...sections import Choice, Coupling, Output, Sections, Time

SLENDEREST = 50.0  # longest over shortest axis
RATIO = {"least": 1e-6, "most": 1e6}
# Velocity gradients over the rate, rows are velocity components.
GRADIENTS: Mapping[str, np.ndarray] = {
    "planar-extension": np.diag([0.5, -0.5, 0.0]),
    "uniaxial-extension": np.diag([1.0, -0.5, -0.5]),
    "shear": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
}


@dataclass(frozen=True)
class SphereShape:
    """The unit sphere."""

    kind: str = rule("sphere", choices=("sphere",))

    @property
    def scales(self) -> np.ndarray:
        """Semi-axes along x, y, z."""
        return np.ones(3)


@dataclass(frozen=True)
class EllipsoidShape:
    """An ellipsoid of the unit sphere's volume; ``axes``: ratios of its semi-axes along x, y, z."""

    kind: str = rule("ellipsoid", choices=("ellipsoid",))
    axes: tuple[float, float, float] = rule((2.0, 1.0, 1.0), least=0.02, most=50.0)

    @property
    def scales(self) -> np.ndarray:
        """Semi-axes along x, y, z."""
        ratios = np.array(self.axes)
        return ratios / np.prod(ratios) ** (1.0 / 3.0)


@dataclass(frozen=True)
class CapsuleMesh:
    """Degree, rows from pole to pole, elements around the third axis (a multiple of four)."""

    degree: int = rule(3, choices=(2, 3))
    rows: int = rule(8, least=4, most=1024)
    around: int = rule(12, least=8, most=1024)


@dataclass(frozen=True)
class _Membrane(ABC):
    """Membrane of unit stiffness E h/(1 - nu^2), unstressed in its start shape."""

    stiffness: ClassVar[float] = 1.0

    density: float = rule(1.0, least=1e-9, most=1e9)
    flexural_rigidity: float = rule(1e-5, least=1e-14, most=100.0)

    @property
    @abstractmethod
    def poisson(self) -> float:
        """Ratio nu of small strains."""

    @property
    def shear_modulus(self) -> float:
        """Gs = E h / (2 (1 + nu))."""
        return 0.5 * (1.0 - self.poisson) * self.stiffness


@dataclass(frozen=True)
class HookeMembrane(_Membrane):
    """St. Venant-Kirchhoff: linear in the Green strain."""

    law: str = rule("st-venant-kirchhoff", choices=("st-venant-kirchhoff",))
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)

    @property
    def poisson(self) -> float:
        return self.poisson_ratio


@dataclass(frozen=True)
class RubberMembrane(_Membrane):
    """Neo-Hookean, incompressible in its thickness: nu = 1/2."""

    law: str = rule("neo-hookean", choices=("neo-hookean",))

    @property
    def poisson(self) -> float:
        return 0.5


@dataclass(frozen=True)
class SkalakMembrane(_Membrane):
    """Skalak's law; ``area_modulus`` is C, the resistance to dilatation: nu = C / (1 + C)."""

    law: str = rule("skalak", choices=("skalak",))
    area_modulus: float = rule(1.0, least=0.0, most=1000.0)

    @property
    def poisson(self) -> float:
        return self.area_modulus / (1.0 + self.area_modulus)


CapsuleStructure = HookeMembrane | RubberMembrane | SkalakMembrane


@dataclass(frozen=True)
class CapsuleFluid:
    """Stokes flow in and around; ``mass_ratio`` m = varpi/Re is that of the fluid inside."""

    model: ClassVar[str] = "stokes"

    viscosity_ratio: float = rule(1.0, **RATIO)
    mass_ratio: float = rule(1.0, least=1e-12, most=1e12)
    tolerance: float = rule(1e-3, least=1e-10, below=1.0)


@dataclass(frozen=True)
class LinearFlow:
    """Linear flow; ``capillary`` is Ca = (outer viscosity) gdot a / Gs.

    "planar-extension" ``gdot/2 (x, -y, 0)``, "uniaxial-extension" ``gdot (x, -y/2, -z/2)``,
    "shear" ``gdot (y, 0, 0)``.
    """

    kind: str = rule("planar-extension", choices=tuple(GRADIENTS))
    capillary: float = rule(0.005, least=1e-9, most=100.0)

    @property
    def gradient(self) -> np.ndarray:
        """Velocity gradient over the rate, ``(3, 3)``."""
        return GRADIENTS[self.kind]


@dataclass(frozen=True)
class CapsuleScene:
    """Everything a capsule run is made of."""

    kind: ClassVar[str] = "capsule"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    geometry: SphereShape | EllipsoidShape = SphereShape()
    mesh: CapsuleMesh = CapsuleMesh()
    structure: CapsuleStructure = HookeMembrane()
    fluid: CapsuleFluid = CapsuleFluid()
    flow: LinearFlow = LinearFlow()
    time: Time = field(default_factory=lambda: Time(dt=5.0, end=100.0))
    coupling: Coupling = field(default_factory=Coupling)
    output: Output = field(default_factory=Output)

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {
            "fluid.tolerance": self.fluid.tolerance,
            "coupling.tolerance": self.coupling.tolerance,
            "coupling.absolute_tolerance": self.coupling.absolute_tolerance,
        }

    @property
    def strain_rate(self) -> float:
        """gdot from the capillary number."""
        f = self.fluid
        shear = self.structure.shear_modulus
        return self.flow.capillary * shear / (f.viscosity_ratio * f.mass_ratio)

    @property
    def exact_deformation(self) -> float:
        """Steady D of small-deformation theory (Barthes-Biesel, Rallison 1981); NaN off spheres.

        ``5/4 (2 + nu)/(1 + nu) Ca (e_1 - e_2)`` at any lambda, with the principal rates of strain
        e_1, e_2 in the xy plane over gdot.
        """
        if not isinstance(self.geometry, SphereShape):
            return float("nan")
        nu, plane = self.structure.poisson, self.flow.gradient[:2, :2]
        rates = np.linalg.eigvalsh(0.5 * (plane + plane.T))
        strain = float(rates[1] - rates[0])
        return 1.25 * (2.0 + nu) / (1.0 + nu) * self.flow.capillary * strain


SECTIONS: Sections = {
    "geometry": Choice("geometry.kind", {"sphere": SphereShape, "ellipsoid": EllipsoidShape}),
    "mesh": CapsuleMesh,
    "structure": Choice(
        "structure.law",
        {
            "st-venant-kirchhoff": HookeMembrane,
            "neo-hookean": RubberMembrane,
            "skalak": SkalakMembrane,
        },
    ),
    "fluid": CapsuleFluid,
    "flow": LinearFlow,
    "time": Time,
    "coupling": Coupling,
    "output": Output,
}


def impossible(scene: CapsuleScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    m, scales = scene.mesh, scene.geometry.scales
    cases = [
        (
            m.around % 4 != 0,
            f"mesh.around: {m.around} must be a multiple of 4, so that both axes of the strain are "
            "alike; use 8, 12 or 16",
        ),
        (
            scales.max() > SLENDEREST * scales.min(),
            f"geometry.axes: one is {scales.max() / scales.min():.3g} times another; the mesh of a "
            f"sphere follows up to {SLENDEREST:g}",
        ),
        *scene.time.impossible(),
    ]
    return [message for wrong, message in cases if wrong]
