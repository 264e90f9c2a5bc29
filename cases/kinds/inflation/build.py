"""An inflation as objects: structure, fluid, scheme and collision test, where the packages meet."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from coupling import Fluid, State
from coupling.contact.watch import Watch
from coupling.schemes.implicit import StructureOnly
from coupling.schemes.scheme import Scheme
from coupling.stepping.operator_reuse import OperatorReuse, reach

from ...geometry.bag import Bag
from ...geometry.bag_sampler import BagSampler
from ...geometry.panels import FoldPanels
from ...geometry.wrinkles import ClothSampler
from ..inflow import prescribed_volume
from ..schemes import scheme as named_scheme
from ..simulated import Simulated
from .config import InflationScene
from .initial_bag import nature
from .membrane import relaxed, structure, unstrained
from .plan import InflationPlan
from .touching import accuracy, contact, fields, test

UNSTRETCHED = 1e-20  # membrane energy of rounding: a bag without folds has nothing to relax


def simulated(scene: InflationScene, bag: Bag | None = None) -> Simulated:
    """Everything a run needs, from one scene; a ``bag`` takes the place of its geometry's."""
    plan = InflationPlan(scene, bag)
    body, sampler = plan.bag, _sampler(scene, plan.bag)
    touching = contact(plan, sampler)
    shell = structure(scene, plan.bag, touching)
    start = State(0.0, body.coefficients, np.zeros_like(body.coefficients))
    if nature(scene, body) == "flat" and shell.energies(start)["membrane"] > UNSTRETCHED:
        start = relaxed(shell, start)
    initial, i = shell.volume(body.coefficients), scene.inflow

    panels = FoldPanels.of(body)

    def diagnostics(state: State) -> Mapping[str, float]:
        found = {"min_gap": sampler.gap(state.coefficients)}
        if panels is not None:
            found["panel_angle"] = float(panels.angles(state.coefficients).max())
        return found

    return Simulated(
        scene,
        structure=shell,
        fluid=partial(reused_fluid, plan) if plan.has_flow else None,
        scheme=scheme(plan),
        volume=prescribed_volume(initial, i.final_volume * initial, i.t1, i.t2),
        initial=start,
        sampler=fields(sampler, touching),
        diagnostics=diagnostics,
        skips=plan.skips(),
        collision=test(plan, touching),
        contact=touching,
        watch=Watch(sampler.gap(body.coefficients), initial) if plan.tested == "auto" else None,
        accuracy=accuracy(plan, touching) if plan.has_flow else None,
    )


def _sampler(scene: InflationScene, body: Bag) -> BagSampler:
    """Draws the bag, and where it wrinkles if it can."""
    if scene.structure.law != "tension-field":
        return BagSampler(body)
    return ClothSampler(body, unstrained(scene, body), scene.structure.poisson_ratio)


def fluid(plan: InflationPlan) -> Fluid:
    """The Stokes model on membrane and inlet."""
    from hbem.flows.enclosed_flow import EnclosedStokes
    from hbem.solvers.saddle import DENSE_LIMIT
    from hbem.surfaces.patches import union

    body, f = plan.bag, plan.scene.fluid
    patches = union(body.membrane, plan.inlet)
    return EnclosedStokes(
        patches,
        np.arange(patches.n_elements) >= body.membrane.n_elements,
        body.profile,
        mass_ratio=f.mass_ratio,
        viscosity_ratio=f.viscosity_ratio,
        orders=plan.orders,
        dense_limit={"lu": 10**9, "gmres": 0}.get(f.solver, DENSE_LIMIT),
        tolerance=f.krylov_tolerance or plan.budget.krylov,
        max_iterations=f.krylov_iterations,
        preconditioner=plan.budget.preconditioner,
        compression=plan.compression,
        traction_tolerance=f.tolerance,
    )


def reused_fluid(plan: InflationPlan) -> Fluid:
    """The fluid of a run, which keeps operators as the scene allows."""
    model, share = fluid(plan), plan.scene.coupling.reuse_tolerance
    if share == 0.0:
        return model
    return OperatorReuse(model, reach(plan.scene.fluid.tolerance, plan.bag.gap, share))


def scheme(plan: InflationPlan) -> Scheme:
    """The coupling scheme of a scene."""
    if not plan.has_flow:
        return StructureOnly()
    return named_scheme(plan.scene.coupling, plan.contraction, plan.scene.time.dt)
