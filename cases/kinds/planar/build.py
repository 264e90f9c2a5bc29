"""A planar scene as objects: curve, structure and fluid; the same simulation as in space."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from coupling import State
from coupling.schemes.implicit import StructureOnly
from coupling.schemes.scheme import Scheme
from hbem.planar.contact import ContactForce
from hbem.planar.polygon import Boundary, OuterRule, smallest_gap
from hbem.planar.potential import PlanarPotential
from hbem.planar.stokes import PlanarStokes
from shells.conditions.curve_ends import end_supports
from shells.energy.area import EnclosedArea
from shells.energy.elastic_string import ElasticString
from shells.energy.material import Material
from shells.energy.planar_shell import PlanarMembrane, PlanarShell
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.curve import CurveBasis

from ..inflow import prescribed_volume
from ..schemes import scheme as named_scheme
from ..simulated import Simulated
from .config import PlanarScene
from .contact import CurveCollision
from .forecast import contraction, final_volume
from .geometry import PlanarBag, planar_bag

LAWS: Mapping[str, type[PlanarMembrane]] = {"kirchhoff-love": PlanarShell, "string": ElasticString}
CHEAP = 10.0  # forming the response costs as much as assembling: measured break-even
SAMPLES = np.linspace(0.0, 1.0, 5)[:-1]  # points of an element in pictures and gap checks


def bag(scene: PlanarScene) -> PlanarBag:
    """Initial geometry of a scene."""
    return planar_bag(scene.geometry, scene.mesh)


def membrane(scene: PlanarScene, body: PlanarBag) -> PlanarMembrane:
    """The energy of the scene's law."""
    c = scene.structure
    material = Material(c.flexural_rigidity, c.stiffness, density=c.density)
    return LAWS[c.law](CurveBasis(body.nodes, body.coefficients), material)


def structure(scene: PlanarScene, body: PlanarBag) -> ShellStructure:
    """The membrane with its supports and its enclosed area."""
    energy = membrane(scene, body)
    E = end_supports(body.coefficients, scene.structure.ends)
    return ShellStructure(energy, E, EnclosedArea(energy.basis))


def fluid(scene: PlanarScene, body: PlanarBag) -> PlanarStokes | PlanarPotential:
    """The flow model."""
    f = scene.fluid
    boundary = Boundary(body.nodes, body.inlet, body.profile)
    rule = OuterRule(f.outer_points, f.near_points)
    if f.model == "stokes":
        return PlanarStokes(boundary, f.mass_ratio, f.viscosity_ratio, f.log_radius, rule)
    contact = ContactForce(f.contact_force, f.contact_cutoff) if f.contact_force else None
    return PlanarPotential(boundary, f.mass_ratio, contact, rule)


def scheme(scene: PlanarScene, body: PlanarBag) -> Scheme:
    """The coupling scheme of a scene."""
    if scene.fluid.model == "pressure":
        return StructureOnly()
    stokes = scene.fluid.model == "stokes"
    rho = contraction(scene, body) if stokes else 0.0
    return named_scheme(scene.coupling, rho, scene.time.dt, cheap=CHEAP)


@dataclass(frozen=True)
class CurveSampler:
    """Curves of configurations for checks, files and pictures."""

    body: PlanarBag
    membrane: PlanarMembrane

    def curve(self, coefficients: np.ndarray) -> np.ndarray:
        """Membrane points ``(n, 2)``, five an element, then those of the inlet."""
        basis = self.membrane.basis
        points = basis.sample(SAMPLES) @ coefficients
        return np.concatenate([points, coefficients[-2:-1], self.body.inlet])

    def diagnostics(self, state: State) -> Mapping[str, float]:
        """Columns of the history."""
        stretch = self.membrane.stretch(state.coefficients)
        points = self.curve(state.coefficients)
        return {
            "min_gap": smallest_gap(points),
            "top": float(points[:, 1].max()),
            "stretch_min": float(stretch.min()),
            "stretch_max": float(stretch.max()),
        }

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None = None,
        velocity: np.ndarray | None = None,
        tessellate: int = 1,
    ) -> dict[str, Any]:
        """The polygon through the nodes as lines with velocity and traction, for files."""
        n = self.body.nodes.size
        points = np.concatenate([coefficients[::2], self.body.inlet])
        total = points.shape[0]
        index = np.arange(total)
        velocity = np.zeros_like(coefficients) if velocity is None else velocity
        data = {"velocity": np.zeros((total, 2))}
        data["velocity"][:n] = velocity[::2]
        if traction is not None:
            # two values meet at a node: their mean
            data["traction"] = 0.5 * (traction[::2] + np.roll(traction[1::2], 1, axis=0))
        return {
            "points": _in_space(points),
            "lines": np.stack([index, (index + 1) % total], axis=1),
            "point_data": {name: _in_space(v) for name, v in data.items()},
            "cell_data": {"part": (index >= n - 1).astype(int)},
        }


def _in_space(vectors: np.ndarray) -> np.ndarray:
    return np.column_stack([vectors, np.zeros(vectors.shape[0])])


def skipped(scene: PlanarScene) -> list[str]:
    """What this scene does not need and a run therefore leaves out."""
    f = scene.fluid
    if f.model == "pressure":
        return ["fluid: uniform pressure, no boundary integrals"]
    if f.model == "potential":
        return [] if f.contact_force else ["contact force: fluid.contact_force = 0"]
    if f.viscosity_ratio == 1.0:
        return ["double layer: equal viscosities need the single layer only"]
    return ["exterior flow: fluid.viscosity_ratio = 0"] if f.viscosity_ratio == 0.0 else []


def simulated(scene: PlanarScene) -> Simulated:
    """Everything a run needs, from one scene."""
    body = bag(scene)
    curve = structure(scene, body)
    sampler = CurveSampler(body, membrane(scene, body))
    start, i = curve.volume(body.coefficients), scene.inflow
    final = final_volume(scene, body, start) * start
    return Simulated(
        scene,
        structure=curve,
        fluid=partial(fluid, scene, body) if scene.fluid.model != "pressure" else None,
        scheme=scheme(scene, body),
        volume=prescribed_volume(start, final, i.t1, i.t2),
        initial=State(0.0, body.coefficients, np.zeros_like(body.coefficients)),
        sampler=sampler,
        diagnostics=sampler.diagnostics,
        skips=tuple(skipped(scene)),
        collision=CurveCollision(sampler.curve, n_inlet=body.inlet.shape[0] + 1),
    )
