"""A capsule scene as frozen dataclasses: a closed spherical membrane in planar strain.

Units as in `cases.sections`, the radius is the length unit. The flow is
``u = gdot/2 (x, -y, 0)`` with ``gdot = Ca Gs / (lambda m)``: Ca counts the outer viscosity
against the membrane's shear modulus ``Gs = (1 - nu) / 2``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from ...limits import rule
from ...sections import Coupling, Output, Sections, Time


@dataclass(frozen=True)
class CapsuleMesh:
    """Degree, rows from pole to pole, elements around the third axis (a multiple of four)."""

    degree: int = rule(3, choices=(2, 3))
    rows: int = rule(8, least=4)
    around: int = rule(12, least=8)


@dataclass(frozen=True)
class CapsuleStructure:
    """Membrane of unit stiffness E h/(1 - nu^2) and unit radius, unstressed as a sphere."""

    stiffness: ClassVar[float] = 1.0

    density: float = rule(1.0, above=0.0)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)
    flexural_rigidity: float = rule(1e-5, above=0.0)

    @property
    def shear_modulus(self) -> float:
        """Gs = E h / (2 (1 + nu))."""
        return 0.5 * (1.0 - self.poisson_ratio) * self.stiffness


@dataclass(frozen=True)
class CapsuleFluid:
    """Stokes flow in and around; ``mass_ratio`` m = varpi/Re is that of the fluid inside."""

    model: ClassVar[str] = "stokes"

    viscosity_ratio: float = rule(1.0, above=0.0)
    mass_ratio: float = rule(1.0, above=0.0)
    tolerance: float = rule(1e-3, above=0.0, below=1.0)
    outer_points: int = rule(3, choices=(2, 3, 4))


@dataclass(frozen=True)
class StrainFlow:
    """Planar strain; ``capillary`` is Ca = (outer viscosity) gdot a / Gs."""

    capillary: float = rule(0.005, above=0.0)


@dataclass(frozen=True)
class CapsuleScene:
    """Everything a capsule run is made of."""

    kind: ClassVar[str] = "capsule"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    mesh: CapsuleMesh = CapsuleMesh()
    structure: CapsuleStructure = CapsuleStructure()
    fluid: CapsuleFluid = CapsuleFluid()
    flow: StrainFlow = StrainFlow()
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
        """Steady D of small-deformation theory, ``(5/4) (2 + nu)/(1 + nu) Ca`` at any lambda."""
        nu = self.structure.poisson_ratio
        return 1.25 * (2.0 + nu) / (1.0 + nu) * self.flow.capillary


SECTIONS: Sections = {
    "mesh": CapsuleMesh,
    "structure": CapsuleStructure,
    "fluid": CapsuleFluid,
    "flow": StrainFlow,
    "time": Time,
    "coupling": Coupling,
    "output": Output,
}


def impossible(scene: CapsuleScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    m = scene.mesh
    cases = [
        (
            m.around % 4 != 0,
            f"mesh.around: {m.around} must be a multiple of 4, so that both axes of the strain are "
            "alike; use 8, 12 or 16",
        ),
        *scene.time.impossible(),
    ]
    return [message for wrong, message in cases if wrong]
