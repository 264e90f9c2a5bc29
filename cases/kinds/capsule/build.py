"""A capsule as objects: the same structure and fluid as for bags, without an inlet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from coupling import State
from coupling.contact.watch import UNTIL, Watch
from hbem.accuracy import Budget, budget
from hbem.flows.enclosed_flow import EnclosedStokes
from shells.conditions.supports import extraction
from shells.energy.densities import NeoHookean, Skalak
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.interface import ShellEnergy
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.bag import Bag
from ...geometry.bag_sampler import BagSampler
from ...geometry.revolution import sphere
from ...output.accuracy import Accuracy
from ..collision import collision
from ..schemes import scheme
from ..simulated import Simulated
from .config import CapsuleScene
from .forecast import contraction


def capsule(scene: CapsuleScene) -> Bag:
    """The membrane: a bag without inlet, the image of a fitted sphere."""
    m, scales = scene.mesh, scene.geometry.scales
    surface, coefficients = sphere(m.degree, m.rows, m.around)
    return Bag(
        surface,
        None,
        coefficients * scales,
        support=lambda rim: extraction(surface.reduction),
        profile=None,
        gap=2.0 * float(scales.min()),
        extent=float(scales.max()),
        exact_volume=4.0 * np.pi / 3.0,
        fit_error=float("nan"),
    )


# each law by its word: a surface and a material to an energy
LAWS: Mapping[str, Callable[[SurfaceBasis, Material], ShellEnergy]] = {
    "st-venant-kirchhoff": KirchhoffLove,
    "neo-hookean": lambda basis, material: HyperelasticShell(basis, NeoHookean(material)),
    "skalak": lambda basis, material: HyperelasticShell(basis, Skalak(material)),
}


def structure(scene: CapsuleScene, body: Bag) -> ShellStructure:
    """The closed membrane, free to move, and its constant volume."""
    c = scene.structure
    assert isinstance(body.membrane, SplineSurface)
    basis = SurfaceBasis(body.membrane, body.coefficients)
    material = Material(c.flexural_rigidity, c.stiffness, c.poisson, c.density)
    energy = LAWS[c.law](basis, material)
    return ShellStructure(energy, body.support(""), EnclosedVolume(basis))


def asked_of(scene: CapsuleScene, body: Bag) -> Budget:
    """Tolerances of the boundary integrals from that of the traction."""
    return budget(scene.fluid.tolerance, body.gap, body.extent)


def fluid(scene: CapsuleScene, body: Bag) -> EnclosedStokes:
    """Stokes flow on both sides of the membrane in the scene's linear flow."""
    f = scene.fluid
    asked = asked_of(scene, body)
    gradient = scene.strain_rate * scene.flow.gradient
    return EnclosedStokes(
        body.membrane,
        np.zeros(body.membrane.n_elements, dtype=bool),
        None,
        mass_ratio=f.mass_ratio,
        viscosity_ratio=f.viscosity_ratio,
        orders=asked.orders,
        tolerance=asked.krylov,
        traction_tolerance=f.tolerance,
        background=lambda points: points @ gradient.T,
    )


class EqualMoments:
    """The ellipsoid with a body's volume moments of second order, cut by the xy plane.

    Parameters
    ----------
    body : Bag
    """

    def __init__(self, body: Bag):
        x, w = np.polynomial.legendre.leggauss(body.membrane.degree + 3)
        xi, eta = (0.5 * (g.ravel() + 1.0) for g in np.meshgrid(x, x, indexing="ij"))
        self._samples = [body.membrane.sample(xi, eta, k) for k in (None, 0, 1)]
        self._weights = np.tile(0.25 * np.outer(w, w).ravel(), body.membrane.n_elements)

    def __call__(self, coefficients: np.ndarray) -> tuple[float, float]:
        """Taylor's deformation and the angle of the long axis with x in degrees.

        Parameters
        ----------
        coefficients : (n, 3) array

        Returns
        -------
        D : float
            ``(L - B) / (L + B)`` of the semi-axes in the plane.
        angle : float
        """
        points, s, t = (sample @ coefficients for sample in self._samples)
        points = points - points.mean(axis=0)
        # a cone over a piece of surface: dV = (x . n) dS / 3, moments of orders 0, 1, 2
        cone = self._weights * np.einsum("ij,ij->i", points, np.cross(s, t))
        volume, first = cone.sum() / 3.0, cone @ points / 4.0
        second = np.einsum("i,ij,ik->jk", cone, points, points) / 5.0
        second -= np.outer(first, first) / volume
        # sections of the ellipsoid x^T M^-1 x = 5 / V through its middle
        section = np.linalg.inv(np.linalg.inv(second)[:2, :2])
        squares, axes = np.linalg.eigh(section)
        short, long = np.sqrt(squares)
        angle = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
        return float((long - short) / (long + short)), float((angle + 90.0) % 180.0 - 90.0)


def simulated(scene: CapsuleScene) -> Simulated:
    """Everything a run needs, from one scene."""
    body = capsule(scene)
    shell = structure(scene, body)
    start = shell.volume(body.coefficients)
    sampler = BagSampler(body)
    skips = [f"test for self-intersection: {UNTIL}"]
    if scene.fluid.viscosity_ratio == 1.0:
        skips.append("double layer: equal viscosities need the single layer only")

    measured, theory = EqualMoments(body), scene.exact_deformation

    def diagnostics(state: State) -> Mapping[str, float]:
        found, angle = measured(state.coefficients)
        gap = sampler.gap(state.coefficients)
        row = {"deformation": found, "angle": angle, "min_gap": gap}
        # without a sphere there is no theory
        return row if np.isnan(theory) else {**row, "to_theory": found / theory - 1.0}

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
        accuracy=Accuracy(asked_of(scene, body), body.gap, body.extent),
    )
