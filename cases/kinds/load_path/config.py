"""A shell under a growing load as frozen dataclasses: fields, defaults and admissible ranges.

The only kind with dimensional numbers, in any consistent units: those of the published benchmarks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ...sections import rule


@dataclass(frozen=True)
class Geometry:
    """Flat shell, clamped at the start of its longer direction, loaded at the other end.

    ``strip``: ``length`` times ``width``. ``annulus``: between the radii ``inner`` and ``outer``,
    slit along the x axis; one lip of the slit is clamped, the other one loaded.
    """

    kind: str = rule("strip", choices=("strip", "annulus"))
    length: float = rule(10.0, above=0.0)
    width: float = rule(1.0, above=0.0)
    inner: float = rule(6.0, above=0.0)
    outer: float = rule(10.0, above=0.0)


@dataclass(frozen=True)
class Mesh:
    """Spline degree, elements from the clamped to the loaded end and across."""

    degree: int = rule(3, choices=(2, 3, 4))
    along: int = rule(16, least=2, most=1024)
    across: int = rule(1, least=1, most=1024)


@dataclass(frozen=True)
class Structure:
    """Isotropic St. Venant-Kirchhoff material in plane stress.

    ``membrane = "patch"`` takes the reduced points of the membrane energy that do not lock.
    """

    thickness: float = rule(0.1, above=0.0)
    young_modulus: float = rule(1.2e6, above=0.0)
    poisson_ratio: float = rule(0.0, above=-1.0, most=0.5)
    membrane: str = rule("gauss", choices=("gauss", "patch"))


@dataclass(frozen=True)
class Load:
    """What acts on the loaded end, per unit of its length; it grows in ``steps`` equal steps.

    ``force`` keeps its direction, ``moment`` turns with the end, positive towards +z. A step whose
    equilibrium is not found is halved, again and again down to a millionth of the path.
    """

    kind: str = rule("force", choices=("force", "moment"))
    force: tuple[float, float, float] = rule((0.0, 0.0, 4.0))
    moment: float = rule(0.0)
    steps: int = rule(20, least=1, most=10000)


@dataclass(frozen=True)
class Output:
    """Steps between field files (0: none), their cells per element and direction, the picture."""

    fields_every: int = rule(1, least=0)
    tessellate: int = rule(3, least=1, most=10)
    picture: bool = rule(True)


@dataclass(frozen=True)
class Scene:
    """Everything a load path is made of."""

    kind: ClassVar[str] = "shell"
    physical: ClassVar[None] = None

    name: str
    description: str = ""
    geometry: Geometry = Geometry()
    mesh: Mesh = Mesh()
    structure: Structure = Structure()
    load: Load = Load()
    output: Output = Output()

    @property
    def tolerances(self) -> dict[str, float]:
        """For run.json."""
        return {"newton.update": NEWTON}


NEWTON = 1e-9  # largest Newton update over the extent of the shell
SECTIONS: Mapping[str, type] = {
    "geometry": Geometry,
    "mesh": Mesh,
    "structure": Structure,
    "load": Load,
    "output": Output,
}


def extent(scene: Scene) -> float:
    """Length from the clamped to the loaded end."""
    g = scene.geometry
    return g.length if g.kind == "strip" else 3.141592653589793 * (g.inner + g.outer)


def impossible(scene: Scene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    g, h, f = scene.geometry, scene.structure.thickness, scene.load
    across = g.width if g.kind == "strip" else g.outer - g.inner
    named = "geometry.width" if g.kind == "strip" else "geometry.outer - geometry.inner"
    cases = [
        (
            g.kind == "annulus" and g.outer <= g.inner,
            f"geometry.outer: {g.outer:g} must exceed geometry.inner = {g.inner:g}",
        ),
        (
            across > 0.0 and h > min(across, extent(scene)),
            f"structure.thickness: {h:g} makes this no shell; it must be below {named} = "
            f"{across:g} and the length {extent(scene):.4g}",
        ),
        (
            f.kind == "force" and not any(f.force),
            "load.force: is zero and moves nothing; give a force per length, for example "
            "[0.0, 0.0, 1.0]",
        ),
        (
            f.kind == "moment" and f.moment == 0.0,
            "load.moment: is zero and moves nothing; give a moment per length",
        ),
    ]
    return [message for wrong, message in cases if wrong]
