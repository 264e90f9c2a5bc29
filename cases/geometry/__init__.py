"""Initial geometries of scenes, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..config import Scene
    from .bag import Bag


def initial_bag(scene: Scene) -> Bag:
    """The fitted bag of a scene."""
    from .pancake import Pancake, pancake

    g, m = scene.geometry, scene.mesh
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
