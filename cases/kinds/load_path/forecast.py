"""Forecast of a load path before any work: sizes, cost, and warnings with remedies."""

from __future__ import annotations

from ...output.forecast import GIGABYTE, Forecast, Item
from .. import locking
from ..sizes import Sizes, shell_bytes
from .config import EndForce, EndMoment, LoadPathScene
from .published import reference

# Measured on one core: seconds of an element's energy, gradient and tangent, by degree.
ELEMENT = {2: 1.4e-5, 3: 6e-5, 4: 2.2e-4}
NEWTON = 8  # iterations a step: 6.5, 9 and 7.6 on the shipped scenes, failed increments included


def unknowns(scene: LoadPathScene) -> int:
    """Displacement components before supports."""
    m = scene.mesh
    return 3 * (m.along + m.degree) * (m.across + m.degree)


def sizes(scene: LoadPathScene) -> Sizes:
    """Counts and memory from the numbers of the mesh."""
    m = scene.mesh
    elements, n = m.along * m.across, unknowns(scene)
    memory = {"shell": shell_bytes(elements, m.degree, n)}
    return Sizes(elements, n, memory, "lower mesh.along or mesh.across")


def forecast(scene: LoadPathScene) -> Forecast:
    """Sizes, cost and warnings of a scene; loads no finite elements."""
    g, m, c, load = scene.geometry, scene.mesh, scene.structure, scene.load
    length, across = g.path, g.across
    elements, iterations = m.along * m.across, NEWTON * load.steps
    known = reference(scene)
    band = 3 * (m.degree + 1) * (m.across + m.degree)
    items = [
        Item("elements", elements, "", f"{length / m.along:.3g} x {across / m.across:.3g}"),
        Item("unknowns", unknowns(scene), "", "before supports"),
        Item("length over thickness", length / c.thickness),
        Item("load steps", load.steps, "", "halved where no equilibrium is found"),
        Item("Newton iterations", iterations, "", f"estimated: {NEWTON} a step"),
        Item("factor", 16.0 * band * unknowns(scene) / GIGABYTE, "GB", "at most, one at a time"),
        Item("assembly", iterations * elements * ELEMENT[m.degree], "s", "estimated, one core"),
        Item("compared with", known.source if known else "nothing", "", _where(scene)),
        Item("fluid", "none", "", "structure only: no boundary integrals, no time"),
    ]
    return Forecast(tuple(items), tuple(_warnings(scene)))


def _where(scene: LoadPathScene) -> str:
    known = reference(scene)
    if known is None:
        return "history.csv holds no deviation"
    n = scene.load.steps
    count = sum(known.at(k / n) is not None for k in range(1, n + 1))
    return f"at {count} of {n} steps"


def _warnings(scene: LoadPathScene) -> list[str]:
    m, c = scene.mesh, scene.structure
    size, radius = scene.geometry.path / m.along, bending_radius(scene)
    warnings = []
    if isinstance(scene.load, EndMoment) and radius < 5.0 * c.thickness:
        warnings.append(
            f"load.moment bends the shell to a radius of {radius:.2g}, below five times its "
            f"thickness {c.thickness:g}: thin-shell theory ends there; lower load.moment"
        )
    x = size**2 / (radius * c.thickness)
    lost = locking.loss(x, min(m.degree, 3), c.membrane)
    if lost > locking.LIMIT:
        warnings.append(
            f"membrane locking: elements of {size:.2g} where size^2/(radius thickness) = {x:.2g} "
            f"may lose up to {lost:.0%} of the bending response; use mesh.degree = 3 with "
            "structure.membrane = 'reduced', or raise mesh.along"
        )
    known, n = reference(scene), scene.load.steps
    if known and all(known.at(k / n) is None for k in range(1, n)):
        warnings.append(
            f"load.steps = {n} meets no published load fraction before the last; use 20 or 40"
        )
    return warnings


def bending_radius(scene: LoadPathScene) -> float:
    """Radius the loaded shell bends to: of the end moment, else a third of its length."""
    c, load, length = scene.structure, scene.load, scene.geometry.path
    if isinstance(load, EndForce):
        return length / 3.0
    stiffness = c.young_modulus * c.thickness**3 / (12.0 * (1.0 - c.poisson_ratio**2))
    return stiffness / abs(load.moment)
