"""The one factory: a validated scene becomes surfaces, structure, fluid and a simulation.

The only place where shells, hbem and coupling meet. Everything heavy is imported here, so that
listing and checking scenes stays light.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from coupling.protocols import Recorder, State
from coupling.schemes.contraction import contraction_measured
from coupling.schemes.implicit import StructureOnly
from coupling.stepping.integrator import BDF2, BackwardEuler
from coupling.stepping.step_control import StepControl
from coupling.stepping.time_loop import Simulation, Tolerances
from shells.energy.kirchhoff_love import KirchhoffLove, curvature_in_frame
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.bag import Bag
from ...geometry.bag_sampler import Sampler
from ...geometry.folded import FoldedBag
from ..inflow import prescribed_volume
from ..schemes import iterations
from ..schemes import scheme as named_scheme
from .config import Scene
from .contact import _collision, _tested
from .fluid import fluid, kept
from .initial_bag import initial_bag
from .plan import compression, contraction, fluid_budget

RELAXATION_STEP, RELAXATION_STEPS = 0.05, 10  # in wave times of the unit length


def structure(scene: Scene, body: Bag) -> ShellStructure:
    """The membrane with its rim, poles and enclosed volume."""
    c = scene.structure
    surface = body.membrane
    folded = body.coefficients[: body.n_membrane]
    flat = body.flat[: body.n_membrane] if isinstance(body, FoldedBag) else folded
    natural = flat if c.reference == "flat" else folded
    basis = SurfaceBasis(surface, natural, points=c.quadrature or None)
    # a bag folded from flat cloth wants to unfold: metric as it is, curvature of the flat bag;
    # creases that have set do not
    unfolds = flat is not folded and c.reference != "creased"
    curvature = curvature_in_frame(basis.reference, basis.jets(flat)) if unfolds else None
    lid = SurfaceBasis(body.patch, body.coefficients[body.n_membrane :])
    offset = EnclosedVolume(lid).value(body.coefficients[body.n_membrane :])
    material = Material(c.flexural_rigidity, c.stiffness, c.poisson_ratio, c.density)
    shell = KirchhoffLove(basis, material, curvature=curvature, membrane=c.membrane)
    return ShellStructure(shell, body.support(c.inflow_rim), EnclosedVolume(basis, offset))


def relaxed(shell: ShellStructure, start: State) -> State:
    """A stretched start after some overdamped steps at constant volume, at rest.

    Velocities are dropped after each step, so that the folds' membrane energy does not become
    motion. The steps are short against the unfolding: the folds stay.
    """
    at_rest, volume = np.zeros_like(start.velocity), shell.volume(start.coefficients)
    state, dt, left = start, RELAXATION_STEP, RELAXATION_STEPS
    while left and dt > 1e-4 * RELAXATION_STEP:
        step = shell.step(State(0.0, state.coefficients, at_rest, state.pressure), None, dt, volume)
        if step.ok:
            state, left = step.state, left - 1
        else:
            dt *= 0.5
    return State(0.0, state.coefficients, at_rest, state.pressure)


def scheme(scene: Scene) -> object:
    """The coupling scheme of a scene."""
    if scene.fluid.model == "pressure":
        return StructureOnly()
    return named_scheme(scene.coupling, contraction(scene), scene.time.dt)


def chosen(scene: Scene) -> object:
    """The scene's scheme."""
    return scheme(scene)


def measured_contraction(scene: Scene, state: State | None = None) -> float:
    """rho at the scene's dt by power iteration on the fluid assembled on one configuration."""
    body = initial_bag(scene)
    c = body.coefficients if state is None else state.coefficients
    state = State(0.0, c, np.zeros_like(c)) if state is None else state
    inverse = structure(scene, body).linearised(state, scene.time.dt)
    return contraction_measured(fluid(scene, body).assemble(c).response(), inverse, scene.time.dt)


def skipped(scene: Scene) -> list[str]:
    """What this scene does not need and a run therefore leaves out."""
    skips = []
    if scene.fluid.model == "pressure":
        skips.append("fluid: uniform pressure, no boundary integrals")
    else:
        skips += _fluid_skipped(scene)
    if not _tested(scene):
        skips.append(
            f"test for self-intersection: contact.test = {scene.contact.test!r}, unfolded bag"
        )
    return skips


def _fluid_skipped(scene: Scene) -> list[str]:
    skips = []
    if scene.fluid.viscosity_ratio == 1.0:
        skips.append("double layer: equal viscosities need the single layer only")
    body = initial_bag(scene)
    if compression(scene, body, fluid_budget(scene, body)) is None:
        unknowns = 3 * (body.membrane.n_dofs + body.patch.n_dofs)
        skips.append(f"compression: dense or direct serves {unknowns} unknowns best")
    return skips


def fields(scene: Scene) -> Sampler:
    """Sampler of a scene's configurations."""
    return Sampler(initial_bag(scene))


def simulation(scene: Scene, recorders: Sequence[Recorder] = ()) -> Simulation:
    """Everything a run needs, from one scene."""
    body = initial_bag(scene)
    shell = structure(scene, body)
    sampler = Sampler(body)
    start = State(0.0, body.coefficients, np.zeros_like(body.coefficients))
    if isinstance(body, FoldedBag) and scene.structure.reference == "flat":
        start = relaxed(shell, start)
    t = scene.time
    limit = iterations(scene.coupling)
    volume: Callable[[float], float] = prescribed_volume(
        scene.inflow, shell.volume(body.coefficients)
    )

    def diagnostics(state: State) -> Mapping[str, float]:
        found = {"min_gap": sampler.gap(state.coefficients)}
        if isinstance(body, FoldedBag):
            found["panel_angle"] = float(body.panel_angles(state.coefficients).max())
        return found

    return Simulation(
        structure=shell,
        fluid=kept(scene, body),
        scheme=scheme(scene),
        volume=volume,
        initial=start,
        control=StepControl(
            t.dt, t.end, t.step_growth, t.dt_floor, error=t.error, closing=t.closing
        ),
        tolerances=Tolerances(scene.coupling.tolerance, scene.coupling.absolute_tolerance, limit),
        recorders=recorders,
        diagnostics=diagnostics,
        checkpoint_every=scene.output.checkpoint_every,
        integrator=BDF2() if t.integrator == "bdf2" else BackwardEuler(),
        collision=_collision(scene, body),
    )
