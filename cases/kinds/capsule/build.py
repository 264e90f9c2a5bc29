"""The factory of capsule scenes: the same structure, fluid and simulation as for bags."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from coupling.protocols import Recorder, State
from coupling.schemes.contraction import contraction_measured
from coupling.stepping.integrator import BDF2, BackwardEuler
from coupling.stepping.step_control import StepControl
from coupling.stepping.time_loop import Simulation, Tolerances
from hbem.accuracy import budget
from hbem.flows.enclosed_flow import EnclosedStokes
from shells.conditions.supports import extraction
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.bag import Bag
from ...geometry.bag_sampler import Sampler
from ...geometry.revolution import sphere
from ..schemes import iterations
from ..schemes import scheme as named_scheme
from .config import Scene
from .forecast import contraction


def capsule(scene: Scene) -> Bag:
    """The spherical membrane: a bag without inflow patch."""
    m = scene.mesh
    surface, coefficients = sphere(m.degree, m.rows, m.around)
    return Bag(
        surface,
        None,
        coefficients,
        support=lambda rim: extraction(surface.reduction),
        profile=None,
        gap=2.0,
        extent=1.0,
        exact_volume=4.0 * np.pi / 3.0,
        fit_error=float("nan"),
    )


def structure(scene: Scene, body: Bag) -> ShellStructure:
    """The closed membrane, free to move, and its constant volume."""
    c = scene.structure
    basis = SurfaceBasis(body.membrane, body.coefficients)
    material = Material(c.flexural_rigidity, c.stiffness, c.poisson_ratio, c.density)
    return ShellStructure(KirchhoffLove(basis, material), body.support(""), EnclosedVolume(basis))


def fluid(scene: Scene, body: Bag) -> EnclosedStokes:
    """Stokes flow on both sides of the membrane in planar strain."""
    f, rate = scene.fluid, scene.strain_rate
    asked = budget(f.tolerance, body.gap, body.extent)
    strain = 0.5 * rate * np.array([1.0, -1.0, 0.0])
    return EnclosedStokes(
        body.membrane,
        np.zeros(body.membrane.n_elements, dtype=bool),
        None,
        mass_ratio=f.mass_ratio,
        viscosity_ratio=f.viscosity_ratio,
        orders=asked.orders,
        tolerance=asked.krylov,
        background=lambda points: strain * points,
    )


def scheme(scene: Scene) -> object:
    """The coupling scheme of a scene."""
    return named_scheme(scene.coupling, contraction(scene), scene.time.dt)


chosen = scheme


def measured_contraction(scene: Scene, state: State | None = None) -> float:
    """rho at the scene's dt by power iteration on the fluid assembled on one configuration."""
    body = capsule(scene)
    c = body.coefficients if state is None else state.coefficients
    state = State(0.0, c, np.zeros_like(c)) if state is None else state
    inverse = structure(scene, body).linearised(state, scene.time.dt)
    return contraction_measured(fluid(scene, body).assemble(c).response(), inverse, scene.time.dt)


def skipped(scene: Scene) -> list[str]:
    """What this scene does not need and a run therefore leaves out."""
    skips = ["test for self-intersection: a single convex body"]
    if scene.fluid.viscosity_ratio == 1.0:
        skips.append("double layer: equal viscosities need the single layer only")
    return skips


def fields(scene: Scene) -> Sampler:
    """Sampler of a scene's configurations."""
    return Sampler(capsule(scene))


def deformation(body: Bag, coefficients: np.ndarray) -> float:
    """Taylor's D = (L - B)/(L + B) from the semi-axes along x and y."""
    x = np.linspace(0.0, 1.0, 5)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    points = body.membrane.sample(xi, eta) @ coefficients
    long, short = np.ptp(points[:, 0]), np.ptp(points[:, 1])
    return float((long - short) / (long + short))


def simulation(scene: Scene, recorders: Sequence[Recorder] = ()) -> Simulation:
    """Everything a run needs, from one scene."""
    body = capsule(scene)
    shell = structure(scene, body)
    t, c = scene.time, scene.coupling
    start = shell.volume(body.coefficients)

    def diagnostics(state: State) -> Mapping[str, float]:
        found = deformation(body, state.coefficients)
        return {"deformation": found, "to_theory": found / scene.exact_deformation - 1.0}

    return Simulation(
        structure=shell,
        fluid=fluid(scene, body),
        scheme=scheme(scene),
        volume=lambda time: start,
        initial=State(0.0, body.coefficients, np.zeros_like(body.coefficients)),
        control=StepControl(
            t.dt, t.end, t.step_growth, t.dt_floor, error=t.error, closing=t.closing
        ),
        tolerances=Tolerances(c.tolerance, c.absolute_tolerance, iterations(c)),
        recorders=recorders,
        diagnostics=diagnostics,
        checkpoint_every=scene.output.checkpoint_every,
        integrator=BDF2() if t.integrator == "bdf2" else BackwardEuler(),
    )
