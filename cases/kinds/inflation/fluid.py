"""The fluid of an inflation."""

from __future__ import annotations

import numpy as np

from coupling.stepping.operator_reuse import KeptOperators, reach

from ...geometry.bag import Bag
from .config import Scene
from .plan import compression, fluid_budget, quadrature


def kept(scene: Scene, body: Bag) -> object | None:
    """The fluid of a run, which keeps operators as the scene allows."""
    model, share = fluid(scene, body), scene.coupling.frozen
    if model is None or share == 0.0:
        return model
    return KeptOperators(model, reach(scene.fluid.tolerance, body.gap, share))


def fluid(scene: Scene, body: Bag) -> object | None:
    """The Stokes model on membrane and patch; None for uniform pressure."""
    if scene.fluid.model == "pressure":
        return None
    from hbem.flows.enclosed_flow import EnclosedStokes
    from hbem.solvers.saddle import DENSE_LIMIT
    from hbem.surfaces.patches import union

    f, asked = scene.fluid, fluid_budget(scene, body)
    patches = union(body.membrane, body.patch)
    inflow = np.arange(patches.n_elements) >= body.membrane.n_elements
    return EnclosedStokes(
        patches,
        inflow,
        body.profile,
        mass_ratio=f.mass_ratio,
        viscosity_ratio=f.viscosity_ratio,
        orders=quadrature(scene, asked),
        dense_limit={"lu": 10**9, "gmres": 0}.get(f.solver, DENSE_LIMIT),
        tolerance=f.krylov_tolerance or asked.krylov,
        max_iterations=f.krylov_iterations,
        preconditioner=asked.preconditioner,
        compression=compression(scene, body, asked),
    )
