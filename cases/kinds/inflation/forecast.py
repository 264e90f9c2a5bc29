"""Forecast of a run before any work: sizes, memory, contraction, time scales, with warnings.

Needs the geometry only: scikit-fem is not loaded, numba for folded bags alone.
"""

from __future__ import annotations

import numpy as np

from hbem.layers.choice import STORED_LIMIT
from shells.surfaces.local_elements import rule

from ...geometry.bag import Bag
from ...geometry.bag_sampler import tangents
from ...geometry.inspection import inspect, strain_energy
from ...output.forecast import GIGABYTE, Forecast, Item
from .. import locking
from ..expected_accuracy import expected_accuracy
from ..schemes import LIMITS
from ..sizes import MEASURED, Sizes
from .cloth import cloth
from .config import InflationScene, PillowGeometry
from .difficulty import difficulty
from .initial_bag import nature
from .mesh_forecast import drawn, told, users_mesh
from .plan import COARSER, InflationPlan

# Measured on pancakes of 1e2 to 1e3 elements: near (point, element) pairs per outer point.
NEAR_PAIRS_PER_POINT = 24
FINER = {
    "pillow": "raise mesh.around",
    "mesh": "raise mesh.split (each halves all edges), or refine the file at its folds",
}
REFERENCES = {
    "folded": "metric of the folded state, curvature of the flat bag: starts unstretched",
    "flat": "the flat bag: stretched by the folds, starts with a relaxation",
    "creased": "the folded state: at rest when folded, only pressure opens it",
}


def sizes(scene: InflationScene) -> Sizes:
    """Counts and memory from the numbers of the scene."""
    return InflationPlan(scene).sizes


def forecast(scene: InflationScene) -> Forecast:
    """Sizes, time scales and warnings of a scene."""
    plan = InflationPlan(scene)
    if not plan.sizes.quickly_measured:
        return _large(plan)
    items = _sizes(plan)
    locked = _locked(scene, plan.bag)
    warnings = [locked] if locked else []
    more, cautions = users_mesh(plan)
    items = [*more, *items]
    warnings += cautions
    for more, cautions in (
        _folds(scene, plan.bag) if plan.bag.folding is not None else ([], []),
        difficulty(plan),
        cloth(scene, plan.bag, volume(plan.bag)),
    ):
        items += more
        warnings += cautions
    if not plan.has_flow:
        items.append(Item("fluid", "none", "", "uniform pressure: no boundary integrals"))
    else:
        more, cautions = _fluid(plan)
        items += more
        warnings += cautions
    return Forecast(tuple(items), tuple(warnings), drawn(plan), told(plan))


def _inlet_area(plan: InflationPlan) -> float:
    """Area of the inlet, by a rule of three points."""
    xi, eta, weights = rule(plan.inlet.shape, 3)
    c = plan.bag.coefficients[plan.bag.n_membrane :]
    size = np.linalg.norm(np.cross(*tangents(plan.inlet, c, (xi, eta))), axis=1)
    return float(np.tile(weights, plan.inlet.n_elements) @ size)


def volume(body: Bag) -> float:
    """Enclosed volume of the initial bag [T 2.27]."""
    xi, eta, weights = rule(body.membrane.shape, body.membrane.degree + 2)
    total, start = 0.0, 0
    for part in body.parts:
        c = body.coefficients[start : start + part.n_coefficients]
        start += part.n_coefficients
        point = part.sample(xi, eta) @ c
        cone = np.einsum("ij,ij->i", point, np.cross(*tangents(part, c, (xi, eta)))) / 3.0
        total += float(cone @ np.tile(weights, part.n_elements))
    return total


def _locked(scene: InflationScene, body: Bag) -> str | None:
    """The loss and its remedy, if a scene sits in the locked regime."""
    c, degree = scene.structure, scene.mesh.degree
    if c.flexural_rigidity == 0.0 or body.membrane.shape == "triangle":
        return None  # no bending response to lose, or none measured
    x, size = locking.locking_parameter(body, float(np.sqrt(12.0 * c.flexural_rigidity)))
    lost = locking.loss(x, degree, c.membrane)
    if lost < locking.LIMIT:
        return None
    pillow = isinstance(scene.geometry, PillowGeometry)
    others = [
        f"{locking.loss(x, d, m):.1%} with mesh.degree = {d}, structure.membrane = {m!r}"
        for d, m in ((3, "gauss"), (3, "reduced"))
        if not pillow and (d, m) != (degree, c.membrane) and locking.loss(x, d, m) < lost
    ]
    points, values = locking.MEASURED[degree, c.membrane]
    fine = np.exp(np.interp(locking.LIMIT, values, np.log(points)))
    keys = "mesh.around" if pillow else "mesh.rim, mesh.flat_max"
    remedy = f"elements of {size * np.sqrt(fine / x):.2g} there ({keys})"
    return (
        f"membrane locking: elements of {size:.2g} where size^2/(radius thickness) = {x:.2g} lose "
        f"about {lost:.0%} of the bending response; use {' or '.join([*others, remedy])}"
    )


def _sizes(plan: InflationPlan) -> list[Item]:
    scene, body = plan.scene, plan.bag
    start = volume(body)
    volume_error = abs(start / body.exact_volume - 1.0)
    # a crumpled bag has no exact shape to compare with
    compared = "" if np.isnan(volume_error) else f", volume {volume_error:.1e}"
    fitted = f"of the spline fit: largest distance {body.fit_error:.2g}{compared}"
    smoothed = f"of the smooth surface, at most {body.fit_error:.2g} off the facets"
    return [
        Item("elements", plan.elements, "", f"{plan.inlet.n_elements} of them inlet"),
        Item("structure unknowns", 3 * body.membrane.reduction.shape[1], "", "before supports"),
        Item(
            "initial volume",
            start,
            "",
            smoothed if body.membrane.shape == "triangle" else fitted,
        ),
        Item("final volume", scene.inflow.final_volume * start),
        Item("smallest gap", body.gap, "", f"over a lateral extent of {body.extent:g}"),
        Item("steps", int(np.ceil(scene.time.end / scene.time.dt)), "", f"of {scene.time.dt:g}"),
        Item("time of a membrane wave", body.extent, "", "extent over wave speed 1"),
        Item("time of the inflow", scene.inflow.t1 + scene.inflow.t2),
    ]


def _folds(scene: InflationScene, body: Bag) -> tuple[list[Item], list[str]]:
    """How a bag is folded, measured on its fit, against the rules of folding."""
    found, fold = inspect(body), body.folds
    finer = FINER["mesh" if body.membrane.shape == "triangle" else "pillow"]
    low, p1, p99, high = found.stretches
    faced = "nothing" if np.isinf(found.faced) else found.faced
    items = [
        Item("inlet faces", faced, "", "distance outward to the nearest sheet"),
        Item(
            "self-intersections",
            "YES" if found.crosses else "none",
            "",
            "of the sampled bag",
        ),
    ]
    if np.isinf(fold.radius):
        return items, found.warnings(finer)
    rest = nature(scene, body)
    items += [
        Item("fold radius", fold.radius, "", f"fit error {body.fit_error / fold.radius:.2g} of it"),
        Item("elements per fold radius", found.per_radius, "", "1 at least, 2 for strains to 3%"),
        Item("gap over twice the radius", found.curvature, "", "below 1 or sheets turn inside out"),
        Item("between panels", fold.between, "", f"panels {fold.panel:.3g} long"),
        Item("stretch of folding", high, "", f"down to {low:.3g}; 98% in {p1:.3g} .. {p99:.3g}"),
        Item("reference", rest, "", REFERENCES[rest]),
    ]
    if rest == "flat":
        c, strain = scene.structure, max(high - 1.0, 1.0 - low)
        energy, note = strain_energy(body, c.poisson_ratio), f"largest strain {strain:.2g}"
        if c.law == "tension-field":
            whole, strain = energy, high - 1.0
            energy = strain_energy(body, c.poisson_ratio, c.kept_compression)
            note = f"tension only, to strains of {strain:.2g}: {energy / whole:.0%} of 'svk'"
        items.append(Item("initial membrane energy", energy, "", note))
    return items, found.warnings(finer)


def _fluid(plan: InflationPlan) -> tuple[list[Item], list[str]]:
    scene, body, unknowns, rho, asked = (
        plan.scene, plan.bag, plan.unknowns, plan.contraction, plan.budget,
    )  # fmt: skip
    f, memory = scene.fluid, plan.operator_bytes / GIGABYTE
    # relaxation time of the gap against the membrane's stiffness: m S over (pi / 2 l)^2
    symbol = rho / (f.mass_ratio * scene.time.dt)
    lubrication = f.mass_ratio * symbol / (0.5 * np.pi / body.extent) ** 2
    speed = scene.inflow.final_volume * volume(body) / (_inlet_area(plan) * scene.inflow.t2)
    items = [
        Item("fluid unknowns", unknowns, "", "traction coefficients"),
        Item(
            "near pairs", NEAR_PAIRS_PER_POINT * f.outer_points**2 * plan.elements, "", "estimated"
        ),
        *_operator(plan),
        Item("time of lubrication", lubrication, "", "gap against membrane tension"),
        Item("mean inflow speed", speed, "", "membrane wave speed is 1"),
        Item("contraction rho", rho, "", f"of plain subiterations at dt = {scene.time.dt:g}"),
        *expected_accuracy(
            asked, plan.orders, f.krylov_tolerance, compressed=plan.compression is not None
        ),
        _double_layer(f.viscosity_ratio),
    ]
    warnings = list(asked.warnings)
    limit = LIMITS.get(scene.coupling.scheme, np.inf)
    others = ", ".join(f"{k} needs rho < {v:g}" for k, v in LIMITS.items())
    if rho > limit:
        warnings.append(
            f"coupling.scheme = {scene.coupling.scheme!r} diverges: rho = {rho:.2g} at dt = "
            f"{scene.time.dt:g} ({others}); use 'implicit', or time.dt below "
            f"{0.5 * limit / rho * scene.time.dt:.2g}"
        )
    elif rho > 1.0:
        items.append(Item("", "", "", f"'gauss-seidel' would diverge at this dt ({others})"))
    if memory > 4.0 and f.solver == "lu":
        warnings.append(
            f"the dense operator takes {memory:.1f} GB; set fluid.solver = 'auto', or "
            f"{COARSER[scene.geometry.kind]}"
        )
    if speed > 3.0:
        warnings.append(
            f"the mean inflow speed is {speed:.2g} wave speeds: the inlet stretches before the rim "
            "moves; lower inflow.final_volume or raise inflow.t2"
        )
    return items, warnings


def _double_layer(ratio: float) -> Item:
    if ratio == 1.0:
        return Item("double layer", "skipped", "", "equal viscosities need the single layer only")
    return Item("double layer", "assembled", "", f"viscosity ratio {ratio:g}; never compressed")


def _large(plan: InflationPlan) -> Forecast:
    """What numbers alone tell about a bag that takes too long to fit for a forecast."""
    t, f = plan.scene.time, plan.scene.fluid
    items = [
        Item("elements", plan.elements),
        Item("fluid unknowns", plan.unknowns if plan.has_flow else 0),
        Item("memory", plan.sizes.total / GIGABYTE, "GB", "estimated, all together"),
        Item("steps", int(np.ceil(t.end / t.dt)), "", f"of {t.dt:g}"),
    ]
    warnings = [
        f"{plan.elements} elements: the geometry was not measured, which takes more than seconds; "
        f"check it with {MEASURED} elements or fewer ({COARSER[plan.scene.geometry.kind]})"
    ]
    if plan.has_flow:
        items += [
            *_operator(plan),
            *expected_accuracy(
                plan.budget,
                plan.orders,
                f.krylov_tolerance,
                compressed=plan.compression is not None,
            ),
            _double_layer(f.viscosity_ratio),
        ]
        warnings += plan.budget.warnings
    return Forecast(tuple(items), tuple(warnings))


def _operator(plan: InflationPlan) -> list[Item]:
    """What holds the single layer, and how much memory that takes."""
    how, unknowns = plan.compression, plan.unknowns
    memory = plan.operator_bytes / GIGABYTE
    if how is not None:
        note = f"matrix tolerance {how.tolerance:.1e}, {unknowns} unknowns"
        apiece = f"{1e-3 * plan.operator_bytes / unknowns:.3g} kB an unknown, near field included"
        return [
            Item("single layer", f"compressed, {how.method}", "", note),
            Item("compressed operator", memory, "GB", apiece),
        ]
    if unknowns > STORED_LIMIT and plan.scene.fluid.solver != "lu":
        note = f"{unknowns} unknowns, the near field stored"
        return [Item("single layer", "direct sums", "", note), Item("near field", memory, "GB")]
    return [Item("dense operator", memory, "GB", "with a copy and its factors")]
