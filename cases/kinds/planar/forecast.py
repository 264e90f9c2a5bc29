"""Forecast of a planar run before any work: sizes, time scales, contraction, warnings."""

from __future__ import annotations

import numpy as np

from coupling.schemes.contraction import contraction_forecast

from ...output.forecast import Forecast, Item
from ..schemes import LIMITS
from ..sizes import Sizes, dense_bytes
from .config import PlanarScene
from .geometry import PlanarBag, pieces, planar_bag

CURVE = 1e4  # bytes an element: element matrices and banded factors, estimated


def final_volume(scene: PlanarScene, body: PlanarBag, start: float) -> float:
    """The final volume as a multiple of the initial one, ``start``."""
    inflow = scene.inflow
    if inflow.final_volume > 0.0:
        return inflow.final_volume
    full = inflow.fullness * body.perimeter**2 / (4.0 * np.pi)
    return full / start


def contraction(scene: PlanarScene, body: PlanarBag) -> float:
    """Contraction rho of plain subiterations at the scene's time step."""
    return contraction_forecast(
        scene.fluid.mass_ratio,
        scene.time.dt,
        element_size=float(np.diff(body.nodes).min()),
        gap=body.gap,
        extent=body.extent,
    )


def area(body: PlanarBag) -> float:
    """Area of the initial polygon."""
    points = np.concatenate([body.coefficients[::2], body.inlet])
    following = np.roll(points, -1, axis=0)
    return 0.5 * float(np.sum(points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]))


def sizes(scene: PlanarScene) -> Sizes:
    """Counts and memory from the numbers of the mesh."""
    elements = pieces(scene.geometry).count(scene.mesh)
    fluid = {"stokes": 4, "potential": 1, "pressure": 0}[scene.fluid.model]
    unknowns = max(4 * (elements + 1), fluid * (elements + scene.mesh.inlet))
    memory = {"dense operators": 2.0 * dense_bytes(fluid * (elements + scene.mesh.inlet))}
    remedy = "raise mesh.straight and mesh.curved, or lower mesh.uniform or mesh.halvings"
    return Sizes(elements, unknowns, memory | {"curve": CURVE * elements}, remedy)


def forecast(scene: PlanarScene) -> Forecast:
    """Sizes, time scales and warnings of a scene."""
    body = planar_bag(scene.geometry, scene.mesh)
    f, sizes, start = scene.fluid, np.diff(body.nodes), area(body)
    segments = sizes.size + scene.mesh.inlet
    items = [
        Item("elements", sizes.size, "", f"sizes {sizes.min():.3g} to {sizes.max():.3g}"),
        Item("structure unknowns", 4 * (sizes.size + 1), "", "before supports"),
        Item("initial volume", start, "", "of the polygon through the nodes"),
        Item("final volume", start * final_volume(scene, body, start)),
        Item("smallest gap", body.gap, "", f"over a length of {body.extent:g}"),
        Item("element over gap", float(sizes.max() / body.gap)),
        Item("steps", int(np.ceil(scene.time.end / scene.time.dt)), "", f"of {scene.time.dt:g}"),
    ]
    if f.model == "pressure":
        items.append(Item("fluid", "none", "", "uniform pressure: no boundary integrals"))
        return Forecast(tuple(items), ())
    items.append(Item("fluid unknowns", segments * (4 if f.model == "stokes" else 1)))
    if f.model == "potential":
        return Forecast(tuple(items), ())
    rho = contraction(scene, body)
    items.append(Item("contraction rho", rho, "", "of plain subiterations"))
    return Forecast(tuple(items), tuple(_warnings(scene, body, rho)))


def _warnings(scene: PlanarScene, body: PlanarBag, rho: float) -> list[str]:
    f, warnings = scene.fluid, []
    limit = LIMITS.get(scene.coupling.scheme, np.inf)
    if rho > limit:
        warnings.append(
            f"coupling.scheme = {scene.coupling.scheme!r} diverges: rho = {rho:.2g} (it needs "
            f"rho < {limit:g}); use 'implicit', or time.dt below "
            f"{0.5 * limit / rho * scene.time.dt:.2g}"
        )
    ratio = float(np.diff(body.nodes).max() / body.gap)
    if ratio > (50.0 if f.near_points else 1.0):
        warnings.append(
            f"elements are {ratio:.2g} gaps long: the lubrication load is off by more than 5%; "
            "lower mesh.straight" + ("" if f.near_points else " or set fluid.near_points = 16")
        )
    if f.viscosity_ratio > 0.0 and f.log_radius <= body.perimeter / (2.0 * np.pi):
        warnings.append(
            f"fluid.log_radius = {f.log_radius:g} may lie inside the bag, whose boundary is "
            f"{body.perimeter:.3g} long: the outer flow then has no solution; raise it"
        )
    if f.viscosity_ratio == 0.0:
        warnings.append(
            "fluid.viscosity_ratio = 0 leaves the exterior out: nothing keeps outer walls apart"
        )
    return warnings
