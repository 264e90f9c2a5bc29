"""Forecast of a model-adaptive run before any work: sizes, memory, and warnings with remedies."""

from __future__ import annotations

import math

from ...output.forecast import GIGABYTE, Forecast, Item
from ..sizes import Sizes
from .config import AdaptiveFlowScene

# Measured on 1.5e4 to 2.3e5 unknowns: nonzeros of the factors over n log2 n.
FILL = 16.0
GROWTH = 1.75  # elements of a mesh over those before, refining 15% with closure, measured
MATRICES = 3000.0  # bytes an unknown: three forms of 22 functions an element, estimated
AREA = 4.0


def sizes(scene: AdaptiveFlowScene) -> Sizes:
    """Counts and memory from the numbers of the mesh."""
    elements, unknowns = _sizes(scene)
    memory = {"factors": factors(unknowns), "matrices": MATRICES * unknowns}
    return Sizes(elements, unknowns, memory, "lower flow.cells or flow.refinements")


def factors(unknowns: int) -> float:
    """Bytes of the factors of one system."""
    return 12.0 * FILL * unknowns * math.log2(unknowns)


def forecast(scene: AdaptiveFlowScene) -> Forecast:
    """Sizes, memory and warnings of a scene; loads no finite elements."""
    elements, unknowns = _sizes(scene)
    memory = factors(unknowns) / GIGABYTE
    adapted = scene.flow.refinements > 0
    items = [
        Item("elements", elements, "", "triangles, estimated" if adapted else "quadrilaterals"),
        Item("unknowns", unknowns, "", "velocity degree 2, pressure degree 1"),
        Item("factors", memory, "GB", "one at a time"),
        Item("tolerance", scene.adaptivity.tolerance, "", "of the bound, relative to the goal"),
        Item("steps", scene.adaptivity.max_steps, "", "at most"),
    ]
    return Forecast(tuple(items), tuple(_warnings(scene, memory)))


def _sizes(scene: AdaptiveFlowScene) -> tuple[int, int]:
    f = scene.flow
    squares = AREA * f.cells**2
    if not f.refinements:
        # vertices, edges and centres: four velocity nodes a square and one pressure
        return int(squares), int(9 * squares)
    triangles = 2.0 * squares * GROWTH**f.refinements
    return int(triangles), int(4.5 * triangles)


def _warnings(scene: AdaptiveFlowScene, memory: float) -> list[str]:
    f, a = scene.flow, scene.adaptivity
    warnings = []
    if memory > 4.0:
        warnings.append(f"the factors take {memory:.1f} GB; lower flow.cells or flow.refinements")
    if a.adjoint == "mixed" and f.reynolds >= 100.0:
        warnings.append(
            "adaptivity.adjoint = 'mixed': at Re >= 100 its estimate was off by factors of -4 to 9 "
            "early in the loop; it still finds elements, but judge by the error, or use 'full'"
        )
    if f.reynolds > 300.0 and not f.refinements:
        warnings.append(
            f"at Re = {f.reynolds:g} the corner vorticity is a near cancellation: on uniform "
            "meshes up to 1/80 it is 4% to 7% off the refined value; set flow.refinements = 5"
        )
    return warnings
