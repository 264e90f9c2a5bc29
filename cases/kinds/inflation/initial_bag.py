"""The bag that a scene starts from: a pancake, or a pillow that is flat, folded or rolled."""

from __future__ import annotations

from ...geometry.bag import Bag
from ...geometry.pancake import Pancake, pancake
from .config import InflationScene, PancakeMesh, PillowGeometry, PillowMesh


def initial_bag(scene: InflationScene) -> Bag:
    """The fitted bag of a scene."""
    g, m = scene.geometry, scene.mesh
    if isinstance(g, PillowGeometry):
        assert isinstance(m, PillowMesh)  # both are chosen by geometry.kind
        return _pillow(g, m, scene.output.seed)
    assert isinstance(m, PancakeMesh)
    return pancake(
        Pancake(g.radius, g.half_width, g.neck_radius, g.fillet),
        degree=m.degree,
        around=m.around,
        rim=m.rim,
        fillet=m.fillet,
        flat_max=m.flat_max,
        pole=m.pole,
        disc=m.disc,
        double_joints=m.joints == "double",
    )


def _pillow(g: PillowGeometry, m: PillowMesh, seed: int) -> Bag:
    from shells.surfaces.pillow import Pillow

    from ...geometry.folded import folded_bag
    from ...geometry.folding import accordion_folding, double_folding, flat, roll_folding

    foldings = {
        "flat": lambda: flat(g.gap),
        "accordion": lambda: accordion_folding(g.folds, g.panel, g.gap),
        "double": lambda: double_folding(g.folds, g.folds_across, g.panel, g.gap),
        "roll": lambda: roll_folding(g.turns, g.pitch, g.gap),
    }
    return folded_bag(
        Pillow(m.around, m.across or m.around // 2),
        foldings[g.fold](),
        plan=g.plan,
        width=g.width,
        inlet_elements=m.inlet,
        crumpled=g.crumple,
        seed=seed,
    )
