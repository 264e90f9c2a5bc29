"""The bag that a scene starts from."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...geometry.bag import Bag
    from .config import Geometry, Mesh, Scene


def initial_bag(scene: Scene) -> Bag:
    """The fitted bag of a scene."""
    from .pancake import Pancake, pancake

    g, m = scene.geometry, scene.mesh
    if g.kind == "pillow":
        return _pillow(g, m, scene.output.seed)
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


def _pillow(g: Geometry, m: Mesh, seed: int) -> Bag:
    """A flat or folded pillow bag."""
    from shells.surfaces.pillow import Pillow

    from .folded import folded_bag
    from .folding import accordion_folding, double_folding, flat, roll_folding

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
        inlet=m.inlet,
        crumpled=g.crumple,
        seed=seed,
    )
