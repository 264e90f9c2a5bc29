"""The membrane of a bag as a structure: its energy, its rim, what it encloses and touches."""

from __future__ import annotations

import numpy as np

from coupling import State
from coupling.contact.on_demand import Carrying
from shells.energy.frame import curvature_in_frame
from shells.energy.kinks.edge_geometry import kink_angles
from shells.energy.kinks.edge_tables import HeldSlopes
from shells.energy.kinks.triangle_shell import TriangleShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.element_basis import ElementBasis
from shells.surfaces.pillow import Pillow
from shells.surfaces.surface import Surface
from shells.surfaces.surface_basis import SurfaceBasis
from shells.surfaces.tensor_surface import TensorSurface
from shells.surfaces.triangles.triangle_basis import TriangleBasis
from shells.surfaces.triangles.triangle_surface import TriangleSurface

from ...geometry.bag import Bag
from .config import InflationScene
from .initial_bag import nature
from .mesh_config import MeshGeometry

RELAXATION_STEP, RELAXATION_STEPS = 0.05, 10  # in wave times of the unit length


def unstrained(scene: InflationScene, body: Bag) -> np.ndarray:
    """Coefficients of the membrane whose metric is free of stress."""
    whole = body.cut if nature(scene, body) == "flat" else body.coefficients
    return whole[: body.n_membrane]


def structure(scene: InflationScene, body: Bag, touching: Carrying | None = None) -> ShellStructure:
    """The membrane with its rim, poles and enclosed volume, and what it touches."""
    assert body.inlet is not None  # bags of this kind have one
    inlet = body.coefficients[body.n_membrane :]
    offset = EnclosedVolume(basis_of(body.inlet, inlet)).value(inlet)
    shell = energy(scene, body)
    volume = EnclosedVolume(shell.basis, offset)
    return ShellStructure(shell, body.support(scene.structure.inflow_rim), volume, contact=touching)


def basis_of(surface: Surface, reference: np.ndarray, points: int | None = None) -> ElementBasis:
    """The basis of any surface; ``points`` a direction on grids of splines."""
    if isinstance(surface, TriangleSurface):
        return TriangleBasis(surface, reference)
    assert isinstance(surface, TensorSurface)  # a surface is one or the other
    return SurfaceBasis(surface, reference, points=points)


def energy(scene: InflationScene, body: Bag) -> KirchhoffLove:
    """The membrane's energy: smooth splines, or triangles whose kinks are tied."""
    c, surface = scene.structure, body.membrane
    basis = basis_of(surface, unstrained(scene, body), c.quadrature or None)
    material = Material(c.flexural_rigidity, c.stiffness, c.poisson_ratio, c.density)
    # a bag folded from flat cloth wants to unfold: metric as it is, curvature of the flat bag;
    # creases that have set do not
    unfolds = body.flat is not None and nature(scene, body) != "creased"
    flat = body.cut[: body.n_membrane] if unfolds else None
    if isinstance(basis, TriangleBasis):
        # the unfolded bag of a file may lie anywhere
        place = body.coefficients[: body.n_membrane]
        clamped = c.inflow_rim == "clamped" and c.flexural_rigidity > 0.0
        return TriangleShell(
            basis,
            material,
            curvature=flat,
            compression_share=c.kept_compression,
            clamp=HeldSlopes(basis.surface.graph.rim, at=place) if clamped else None,
            soft=_seams(scene, body, basis.surface) if c.seam == "hinged" else None,
        )
    return KirchhoffLove(
        basis,
        material,
        curvature=None if flat is None else curvature_in_frame(basis.reference, basis.jets(flat)),
        membrane=c.membrane,
        compression_share=c.kept_compression,
        hinges=surface.seam if isinstance(surface, Pillow) and c.seam == "hinged" else None,
    )


def _seams(scene: InflationScene, body: Bag, surface: TriangleSurface) -> np.ndarray:
    """Share of the stiffness of each edge: none at the sharp ones of a mesh, its seams."""
    g = scene.geometry
    assert isinstance(g, MeshGeometry)  # triangles come from files
    angles = kink_angles(surface, body.cut[: body.n_membrane])
    return np.where(np.abs(angles).max(axis=1) > np.radians(g.crease), 0.0, 1.0)


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
            s = step.state
            state, left = State(s.t, s.coefficients, s.velocity, s.pressure), left - 1
        else:
            dt *= 0.5
    return State(0.0, state.coefficients, at_rest, state.pressure)
