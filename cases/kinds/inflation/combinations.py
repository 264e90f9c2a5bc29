"""What an inflation cannot be: combinations of single good values, with their remedies."""

from __future__ import annotations

import math
from dataclasses import fields

from .config import (
    BagStructure,
    InflationScene,
    PancakeGeometry,
    PancakeMesh,
    PillowGeometry,
    PillowMesh,
)
from .mesh_config import MeshGeometry, Region

THIN = 1e-14  # smallest flexural rigidity without a tension field
CRUMPLED = 4096  # elements
THINNEST = 1e-5  # gap over extent: beyond it lubrication amplifies rounding to visible errors


def impossible(scene: InflationScene) -> list[str]:
    """Combinations of single good values that cannot work together."""
    g, m = scene.geometry, scene.mesh
    cases = [
        (
            tuple(scene.fluid.polar) != (0, 0) and min(scene.fluid.polar) < 2,
            f"fluid.polar: {list(scene.fluid.polar)} must be at least 2, or [0, 0] for automatic",
        ),
        (
            scene.fluid.compression == "aca" and scene.fluid.outer_points < 3,
            "fluid.compression: 'aca' needs equal outer and source points; set "
            "fluid.outer_points = 3, or use 'h2'",
        ),
        (
            scene.fluid.compression in ("aca", "h2") and scene.fluid.solver == "lu",
            f"fluid.solver: 'lu' needs the dense matrix, fluid.compression = "
            f"{scene.fluid.compression!r} has none; use 'gmres' or 'auto'",
        ),
        (
            scene.inflow.t2 < scene.inflow.t1,
            f"inflow.t2: {scene.inflow.t2:g} lies before the end of the ramp, "
            f"inflow.t1 = {scene.inflow.t1:g}",
        ),
        *_impossible_cloth(scene.structure),
        *scene.time.impossible(),
    ]
    if isinstance(g, PancakeGeometry) and isinstance(m, PancakeMesh):
        cases = [*_impossible_pancake(g, m), *cases]
    if isinstance(g, PillowGeometry) and isinstance(m, PillowMesh):
        cases = [*cases, *_impossible_folds(g, m)]
    if isinstance(g, MeshGeometry):
        cases = [*_impossible_file(g, scene), *cases]
    return [message for wrong, message in cases if wrong]


def _impossible_cloth(c: BagStructure) -> list[tuple[bool, str]]:
    """Sheets that nothing holds where they are compressed."""
    return [
        (
            c.law == "svk" and c.flexural_rigidity < THIN,
            f"structure.flexural_rigidity: {c.flexural_rigidity:g} lets a compressed sheet crumple "
            f"at the size of its elements; use at least {THIN:g}, or structure.law = "
            "'tension-field', under which sheets wrinkle without resistance",
        ),
        (
            c.kept_compression == 0.0 and c.flexural_rigidity == 0.0,
            "structure.compression_share: 0 without flexural rigidity leaves slack cloth no "
            "stiffness at all; use 1e-3, or a structure.flexural_rigidity above 0",
        ),
    ]


def _impossible_pancake(g: PancakeGeometry, m: PancakeMesh) -> list[tuple[bool, str]]:
    needed = g.radius + g.neck_radius + g.fillet
    return [
        (
            g.radius < THINNEST * g.half_width,
            f"geometry.radius: {g.radius:g} is below {THINNEST:g} of half_width = "
            f"{g.half_width:g}: rounding hides the flow in such a gap; raise it",
        ),
        (
            g.half_width <= needed,
            f"geometry.half_width: {g.half_width:g} leaves no lower sheet; it must exceed "
            f"radius + neck_radius + fillet = {needed:g}",
        ),
        (
            m.joints == "double" and m.degree == 2,
            "mesh.joints: 'double' knots on degree 2 break the tangent; use mesh.degree = 3",
        ),
    ]


def _impossible_folds(g: PillowGeometry, m: PillowMesh) -> list[tuple[bool, str]]:
    """Foldings that cannot be: sheets inside out, panels too short, a basis too small."""
    folded, zigzag = g.fold != "flat", g.fold in ("accordion", "double")
    closest = g.pitch if g.fold == "roll" else 2.0
    across = m.across or m.around // 2
    return [
        (
            folded and g.gap >= closest,
            f"geometry.gap: {g.gap:g} fold radii: neighbouring panels would touch or sheets turn "
            f"inside out; it must be below {closest:g}",
        ),
        (
            not folded and g.gap >= 1.0,
            f"geometry.gap: {g.gap:g} of the length is no flat bag; use less than 1",
        ),
        (
            g.crumple > 0.0 and m.around * across > CRUMPLED,
            f"geometry.crumple: {m.around * across} elements take too long to crumple; lower "
            f"mesh.around (at most {CRUMPLED} elements)",
        ),
        (
            zigzag and g.panel <= math.pi,
            f"geometry.panel: {g.panel:g} fold radii leave no room for the folds; it must exceed "
            "pi fold radii (6 or 10 are usual)",
        ),
        (
            g.fold == "double" and g.panel > math.pi and not _pack_fits(g),
            f"geometry.folds_across: {g.folds_across} folds of the pack need more width than there "
            "is; fold less, or raise geometry.panel",
        ),
        (
            m.around % 2 == 1 or across < 6,
            f"mesh.around: a pillow needs an even number of at least 12 elements around and 6 "
            f"across, not {m.around} x {across}",
        ),
        (
            m.inlet > across // 3,
            f"mesh.inlet: {m.inlet} elements are too many for {across} across; use at most "
            f"{across // 3}",
        ),
    ]


def _impossible_file(g: MeshGeometry, scene: InflationScene) -> list[tuple[bool, str]]:
    """Files that are not named, units without a length, regions that say nothing or too much."""
    kinds = [f.name for f in fields(Region)]
    region = g.inlet if isinstance(g.inlet, Region) else Region(hole=(0.0, 0.0, 0.0))
    said = [name for name in kinds if getattr(region, name)]
    counts = {"sphere": 4, "box": 2, "plane": 4, "hole": 3}
    return [
        (not g.file, "geometry.file: is needed, the mesh of the bag"),
        (
            bool(g.unit) and scene.physical is None,
            f"geometry.unit: {g.unit!r} needs the length of [physical]; without it the file counts "
            "in units of L: leave geometry.unit out",
        ),
        (
            len(said) != 1,
            f"geometry.inlet: a region is one of {', '.join(kinds)}, not "
            f"{' and '.join(said) or 'none'}",
        ),
        *(
            (
                len(getattr(region, name)) != counts[name],
                f"geometry.inlet.{name}: needs {counts[name]} "
                f"{'corners' if name == 'box' else 'numbers'}, not {len(getattr(region, name))}",
            )
            for name in said[:1]
        ),
        *(
            (not said, f"geometry.folds[{k}].{key}: is needed, a fold has at, side and radius")
            for k, fold in enumerate(g.folds)
            for key, said in vars(fold).items()
        ),
        (not any(g.along), "geometry.along: has no direction; give one in the pattern's plane"),
        (
            bool(g.folds) and bool(g.reference),
            "geometry.reference: a pattern that geometry.folds folds is its own unfolded bag; give "
            "one of the two",
        ),
        (
            scene.structure.membrane == "reduced",
            "structure.membrane: 'reduced' is a rule of splines; triangles take 'gauss'",
        ),
        (
            scene.structure.quadrature != 0,
            f"structure.quadrature: {scene.structure.quadrature} points a direction are a rule of "
            "splines; triangles have their own, leave the key out",
        ),
    ]


def _pack_fits(g: PillowGeometry) -> bool:
    """Whether the second folds of a pack leave straight panels between them."""
    from ...geometry.folding import pack_radius

    radius = pack_radius(g.folds, g.panel, g.gap)
    return math.pi * radius * (g.folds_across + 1) < 1.0
