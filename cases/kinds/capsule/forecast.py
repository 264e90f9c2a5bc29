"""Forecast of a capsule run before any work: sizes, time scales, contraction, the answer."""

from __future__ import annotations

import numpy as np

from coupling.schemes.contraction import contraction_forecast
from hbem.accuracy import budget
from hbem.layers.choice import STORED_LIMIT

from ...output.forecast import Forecast, Item
from ..expected_accuracy import expected_accuracy
from ..schemes import LIMITS
from ..sizes import NEAR_BYTES, Sizes, dense_bytes, response_bytes, shell_bytes
from .config import CapsuleScene

LARGEST_TURN = 0.1  # shear of a step; backward Euler errs by about its square, bdf2 less


def contraction(scene: CapsuleScene) -> float:
    """Contraction rho of plain subiterations at the scene's time step."""
    m, f = scene.mesh, scene.fluid
    scales = scene.geometry.scales
    size = float(scales.min()) * min(np.pi / m.rows, 2.0 * np.pi / m.around)
    both = 0.5 * (1.0 + f.viscosity_ratio)
    gap, extent = 2.0 * float(scales.min()), float(scales.max())
    rate = contraction_forecast(
        f.mass_ratio, scene.time.dt, element_size=size, gap=gap, extent=extent
    )
    return both * rate


def sizes(scene: CapsuleScene) -> Sizes:
    """Counts and memory from the numbers of the mesh."""
    m = scene.mesh
    elements, coefficients = m.rows * m.around, (m.rows + m.degree) * m.around
    unknowns = 3 * ((m.rows + m.degree - 4) * m.around + 6)
    stored = unknowns <= STORED_LIMIT
    layers = 1 + (scene.fluid.viscosity_ratio != 1.0)
    return Sizes(
        elements,
        unknowns,
        {
            "shell": shell_bytes(elements, m.degree, 3 * coefficients),
            "dense operators": layers * dense_bytes(unknowns) if stored else 0.0,
            "near field": layers * NEAR_BYTES * unknowns,
            "fluid response": response_bytes(scene.coupling, 3 * coefficients),
        },
        "lower mesh.rows or mesh.around",
    )


def forecast(scene: CapsuleScene) -> Forecast:
    """Sizes, time scales and warnings of a scene."""
    m, f, t = scene.mesh, scene.fluid, scene.time
    elements = m.rows * m.around
    shear = scene.structure.shear_modulus
    # the factor was measured (lambda = 1); theory gives the scale
    relaxation = 2.8 * f.mass_ratio * (1.0 + f.viscosity_ratio) / shear
    rho = contraction(scene)
    theory = Item("steady deformation", scene.exact_deformation, "", "small-deformation theory")
    if np.isnan(scene.exact_deformation):
        theory = Item("steady deformation", "no theory", "", "for ellipsoids")
    turn = scene.strain_rate * t.dt
    items = [
        Item("elements", elements),
        Item("steps", int(np.ceil(t.end / t.dt)), "", f"of {t.dt:g}"),
        Item("strain rate", scene.strain_rate, "", "from the capillary number"),
        Item("time of relaxation", relaxation, "", "both viscosities against the shear modulus"),
        theory,
        Item("contraction rho", rho, "", f"of plain subiterations at dt = {t.dt:g}"),
        Item("double layer", "skipped" if f.viscosity_ratio == 1.0 else "assembled"),
    ]
    limit = LIMITS.get(scene.coupling.scheme, np.inf)
    scales = scene.geometry.scales
    asked = budget(f.tolerance, 2.0 * float(scales.min()), float(scales.max()))
    items += expected_accuracy(asked, asked.orders, compressed=False)
    warnings = list(asked.warnings)
    if rho > limit:
        warnings.append(
            f"coupling.scheme = {scene.coupling.scheme!r} diverges: rho = {rho:.2g} (it needs "
            f"rho < {limit:g}); use 'implicit', or time.dt below {0.5 * limit / rho * t.dt:.2g}"
        )
    if scene.flow.kind == "shear" and turn > LARGEST_TURN:
        warnings.append(
            f"time.dt = {t.dt:g} shears by {turn:.2g} in a step, too coarse for a membrane that "
            f"rotates; use time.dt below {LARGEST_TURN / scene.strain_rate:.2g}"
        )
    if scene.flow.capillary > 0.05:
        warnings.append(
            f"flow.capillary = {scene.flow.capillary:g} is beyond small-deformation theory"
        )
    return Forecast(tuple(items), tuple(warnings))
