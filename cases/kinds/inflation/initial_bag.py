"""The bag that a scene starts from: a pancake, a pillow flat, folded or rolled, a user's mesh."""

from __future__ import annotations

from ...geometry.bag import Bag
from ...geometry.folding import Folding, accordion_folding, double_folding, flat, roll_folding
from ...geometry.pancake import Pancake, meridian_rows, pancake
from ...sections import SceneError
from .config import InflationScene, PancakeGeometry, PancakeMesh, PillowGeometry, PillowMesh
from .mesh_config import MeshGeometry, TriangleMesh


def initial_bag(scene: InflationScene) -> Bag:
    """The fitted bag of a scene."""
    g, m = scene.geometry, scene.mesh
    if isinstance(g, MeshGeometry):
        assert isinstance(m, TriangleMesh)  # both are chosen by geometry.kind
        from .users_mesh import bag_of

        return bag_of(g, m, scene.physical)
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


def narrowest(scene: InflationScene) -> tuple[float, float]:
    """Sheet distance and lateral extent of the narrowest region, without fitting a bag."""
    g = scene.geometry
    if isinstance(g, PillowGeometry):
        fold = _folding(g)
        return min(fold.gap, fold.between), 0.5 * fold.panel
    assert isinstance(g, PancakeGeometry)  # the bags of files count themselves
    return 2.0 * g.radius, g.half_width - g.radius


def counts(scene: InflationScene) -> tuple[int, int]:
    """Elements and density functions of membrane and inlet, without fitting a bag."""
    g, m = scene.geometry, scene.mesh
    if isinstance(m, PillowMesh):
        across = m.across or m.around // 2
        # functions over the rim of the inlet are cut in two; those inside belong to it alone
        cut = (m.inlet + 2) ** 2 - max(0, m.inlet - 2) ** 2
        return m.around * across, m.around * across + cut
    assert isinstance(g, PancakeGeometry)  # the bags of files count themselves
    assert isinstance(m, PancakeMesh)
    body = Pancake(g.radius, g.half_width, g.neck_radius, g.fillet)
    rows = meridian_rows(body, m.rim, m.fillet, m.flat_max, m.pole)
    doubled = 3 if m.joints == "double" else 0
    # the two rings of functions at a pole have three in common
    functions = (rows + doubled + m.disc + 2 * m.degree - 4) * m.around + 6
    return (rows + m.disc) * m.around, functions


def nature(scene: InflationScene, bag: Bag) -> str:
    """The stress-free state of a bag: "folded", "flat" or "creased"."""
    said = scene.structure.reference
    if said != "auto":
        return said
    # a mesh file that brings its own unfolded bag means it
    return "folded" if bag.flat is None or bag.folding is not None else "flat"


def _folding(g: PillowGeometry) -> Folding:
    foldings = {
        "flat": lambda: flat(g.gap),
        "accordion": lambda: accordion_folding(g.folds, g.panel, g.gap),
        "double": lambda: double_folding(g.folds, g.folds_across, g.panel, g.gap),
        "roll": lambda: roll_folding(g.turns, g.pitch, g.gap),
    }
    return foldings[g.fold]()


def _pillow(g: PillowGeometry, m: PillowMesh, seed: int) -> Bag:
    from shells.surfaces.pillow import Pillow

    from ...geometry.pillows.crumple import CrumpleError
    from ...geometry.pillows.folded import folded_bag

    try:
        return folded_bag(
            Pillow(m.around, m.across or m.around // 2),
            _folding(g),
            plan=g.plan,
            width=g.width,
            inlet_elements=m.inlet,
            crumpled=g.crumple,
            seed=seed,
        )
    except CrumpleError as error:
        message = (
            f"geometry.crumple: {g.crumple:g} has no effect: {error} (geometry.gap, mesh.around)"
        )
        raise SceneError([message]) from error
