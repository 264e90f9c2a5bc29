"""The one factory: a validated scene becomes surfaces, structure, fluid and a simulation.

The only place where shells, hbem and coupling meet. Everything heavy is imported here, so that
listing and checking scenes stays light.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coupling.contact.smallest_gap import minimum_gap
from coupling.protocols import Recorder, State
from coupling.schemes.contraction import contraction_measured
from coupling.schemes.implicit import StructureOnly
from coupling.stepping.integrator import BDF2, BackwardEuler
from coupling.stepping.operator_reuse import KeptOperators, reach
from coupling.stepping.step_control import StepControl
from coupling.stepping.time_loop import Simulation, Tolerances
from shells.energy.kirchhoff_love import KirchhoffLove, curvature_in_frame
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry import initial_bag
from ...geometry.bag import Bag
from ...geometry.folded import FoldedBag
from ..inflow import prescribed_volume
from ..schemes import iterations
from ..schemes import scheme as named_scheme
from .config import Scene
from .contact import certified
from .forecast import compression, contraction, fluid_budget, quadrature

RELAXATION_STEP, RELAXATION_STEPS = 0.05, 10  # in wave times of the unit length
GAP_SAMPLES = np.array([1.0 / 6.0, 0.5, 5.0 / 6.0])


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


@dataclass(frozen=True)
class Sampler:
    """Points, normals and grids of a configuration for diagnostics and pictures."""

    body: Bag

    @cached_property
    def _gap_maps(self) -> list:
        xi, eta = (g.ravel() for g in np.meshgrid(GAP_SAMPLES, GAP_SAMPLES, indexing="ij"))
        return [
            (part.sample(xi, eta), part.sample(xi, eta, 0), part.sample(xi, eta, 1))
            for part in self.body.parts
        ]

    def split(self, field: np.ndarray) -> list[np.ndarray]:
        """Rows of each part of an array ``(n_full, 3)``."""
        return np.split(field, np.cumsum([p.n_coefficients for p in self.body.parts])[:-1])

    def gap(self, coefficients: np.ndarray) -> float:
        """Smallest gap between facing parts of the bag."""
        points, normals = [], []
        for (x, s, t), c in zip(self._gap_maps, self.split(coefficients), strict=True):
            points.append(x @ c)
            normal = np.cross(s @ c, t @ c)
            normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
        return minimum_gap(np.concatenate(points), np.concatenate(normals), self.body.gap)

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None = None,
        velocity: np.ndarray | None = None,
        tessellate: int = 3,
    ) -> dict[str, object]:
        """Quadrilaterals with point data, for files and pictures.

        Parameters
        ----------
        coefficients, velocity : (n_full, 3) array
        traction : (n_density, 3) array, optional
            Density coefficients (membrane, then patch).
        tessellate : int
            Cells per element and direction.

        Returns
        -------
        dict
            ``points (n, 3)``, ``quads (m, 4)``, ``point_data``, ``cell_data``.
        """
        n = tessellate + 1
        x = np.linspace(0.0, 1.0, n)
        xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
        i, j = (g.ravel() for g in np.meshgrid(range(tessellate), range(tessellate), indexing="ij"))
        cell = np.stack([i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1], axis=1)
        points, quads, part_of, data = [], [], [], {"traction": [], "velocity": []}
        start = 0
        velocity = np.zeros_like(coefficients) if velocity is None else velocity
        ends = np.cumsum([part.n_dofs for part in self.body.parts])[:-1]
        tractions = None if traction is None else np.split(traction, ends)
        for k, part in enumerate(self.body.parts):
            sample = part.sample(xi, eta)
            points.append(sample @ self.split(coefficients)[k])
            offsets = start + np.arange(part.n_elements) * n * n
            quads.append((offsets[:, None, None] + cell).reshape(-1, 4))
            part_of.append(np.full(part.n_elements * tessellate**2, k))
            data["velocity"].append(sample @ self.split(velocity)[k])
            if tractions is not None:
                data["traction"].append(sample @ (part.density_reduction @ tractions[k]))
            start += points[-1].shape[0]
        return {
            "points": np.concatenate(points),
            "quads": np.concatenate(quads),
            "point_data": {name: np.concatenate(v) for name, v in data.items() if v},
            "cell_data": {"part": np.concatenate(part_of)},
        }


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


def _tested(scene: Scene) -> bool:
    """Whether configurations are tested for self-intersection."""
    g = scene.geometry
    folded = g.kind == "pillow" and (g.fold != "flat" or g.crumple > 0.0)
    return scene.contact.test == "on" or (scene.contact.test == "auto" and folded)


def _collision(scene: Scene, body: Bag) -> object | None:
    if not _tested(scene):
        return None
    return certified(body, scene.contact.tessellate, scene.contact.engine)
