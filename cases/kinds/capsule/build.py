"""A capsule as objects: the same structure and fluid as for bags, without an inlet."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from coupling import State
from coupling.contact.watch import UNTIL, Watch
from hbem.accuracy import budget
from hbem.flows.enclosed_flow import EnclosedStokes
from shells.conditions.supports import extraction
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.bag import Bag
from ...geometry.bag_sampler import BagSampler
from ...geometry.revolution import sphere
from ..collision import collision
from ..schemes import scheme
from ..simulated import Simulated
from .config import CapsuleScene
from .forecast import contraction


def capsule(scene: CapsuleScene) -> Bag:
    """The spherical membrane: a bag without inlet."""
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


def structure(scene: CapsuleScene, body: Bag) -> ShellStructure:
    """The closed membrane, free to move, and its constant volume."""
    c = scene.structure
    basis = SurfaceBasis(body.membrane, body.coefficients)
    material = Material(c.flexural_rigidity, c.stiffness, c.poisson_ratio, c.density)
    return ShellStructure(KirchhoffLove(basis, material), body.support(""), EnclosedVolume(basis))


def fluid(scene: CapsuleScene, body: Bag) -> EnclosedStokes:
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


def deformation(body: Bag, coefficients: np.ndarray) -> float:
    """Taylor's D = (L - B)/(L + B) from the semi-axes along x and y."""
    x = np.linspace(0.0, 1.0, 5)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    points = body.membrane.sample(xi, eta) @ coefficients
    long, short = np.ptp(points[:, 0]), np.ptp(points[:, 1])
    return float((long - short) / (long + short))


def simulated(scene: CapsuleScene) -> Simulated:
    """Everything a run needs, from one scene."""
    body = capsule(scene)
    shell = structure(scene, body)
    start = shell.volume(body.coefficients)
    sampler = BagSampler(body)
    skips = [f"test for self-intersection: {UNTIL}"]
    if scene.fluid.viscosity_ratio == 1.0:
        skips.append("double layer: equal viscosities need the single layer only")

    def diagnostics(state: State) -> Mapping[str, float]:
        found = deformation(body, state.coefficients)
        gap = sampler.gap(state.coefficients)
        to_theory = found / scene.exact_deformation - 1.0
        return {"deformation": found, "to_theory": to_theory, "min_gap": gap}

    return Simulated(
        scene,
        structure=shell,
        fluid=partial(fluid, scene, body),
        scheme=scheme(scene.coupling, contraction(scene), scene.time.dt),
        volume=lambda time: start,
        initial=State(0.0, body.coefficients, np.zeros_like(body.coefficients)),
        sampler=sampler,
        diagnostics=diagnostics,
        skips=tuple(skips),
        collision=collision(body),
        watch=Watch(sampler.gap(body.coefficients), start),
    )
