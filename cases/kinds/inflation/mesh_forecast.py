"""Forecast of a bag from a user's mesh: what the file held, what was mended, where to look."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...geometry.meshes.findings import SLIVER, quality
from ...geometry.meshes.mesh_bag import MeshBag
from ...output.forecast import Item
from .plan import InflationPlan

Findings = tuple[list[Item], list[str]]
SIZES = 0.01, 100.0  # extents in units of L beyond which the unit is likely another
THIN = 0.02  # distance of facing sheets over the extent below which films are hard to resolve


def users_mesh(plan: InflationPlan) -> Findings:
    """Items and warnings of a user's mesh; nothing for other bags."""
    bag = plan.bag
    if not isinstance(bag, MeshBag):
        return [], []
    facets = bag.mesh.facets
    found = quality(facets.points, facets.triangles)
    extents = np.ptp(facets.points, axis=0)
    edges = f"edges {found.shortest:.3g} to {found.longest:.3g}, half of them below "
    items = [Item("mesh", len(bag.mesh.control), "", "triangles after repairs and splits")]
    items += [Item(f"group {name}", len(members), "", "triangles")
              for name, members in facets.groups.items()]  # fmt: skip
    items += [
        Item("extents", " x ".join(f"{x:.4g}" for x in extents), "", "in units of L"),
        Item("smallest angle", found.smallest_angle, "deg", f"{edges}{found.median:.3g}"),
        Item("nearest facing sheets", bag.narrowest, "", f"sampled; 2 V / A = {bag.gap:.3g}"),
        Item("inlet faces", bag.faces if np.isfinite(bag.faces) else "nothing", "", "outward"),
        Item("largest kink", _largest_kink(bag), "deg", "between triangles; free of stress"),
    ]
    return items, [*bag.warnings, *found.warnings(), *_sizes(extents), *_film(plan, bag)]


def _largest_kink(bag: MeshBag) -> float:
    """Largest angle between neighbouring triangles of the membrane, degrees."""
    from shells.energy.kinks.edge_geometry import kink_angles

    angles = kink_angles(bag.membrane, bag.coefficients[: bag.n_membrane])
    return float(np.degrees(np.abs(angles).max()))


def _sizes(extents: np.ndarray) -> list[str]:
    size = float(extents.max())
    if SIZES[0] <= size <= SIZES[1]:
        return []
    return [
        f"geometry.unit: the mesh is {size:.3g} units of L long; is the unit of the file another? "
        "Give geometry.unit and [physical] length, or scale the file"
    ]


def _film(plan: InflationPlan, bag: MeshBag) -> list[str]:
    """Sheets so near that the traction between them needs more than this mesh."""
    thin = bag.narrowest / bag.extent
    if not plan.has_flow or thin >= THIN:
        return []
    return [
        f"sheets face each other {bag.narrowest:.3g} apart over an extent of {bag.extent:.3g}: "
        "the traction in such films is mostly the mesh's error; run with fluid.model = 'pressure' "
        "first, raise mesh.split, or open the bag by geometry.opening"
    ]


def picture(plan: InflationPlan, path: Path) -> Path:
    """Draw the mesh with its inlet, and dots where it is worst."""
    from .views.mesh_check import Spot, mesh_picture

    bag = plan.bag
    assert isinstance(bag, MeshBag)
    facets = bag.mesh.facets
    found = quality(facets.points, facets.triangles)
    spots = []
    if found.smallest_angle < 3.0 * SLIVER:
        what = f"smallest angle, {found.smallest_angle:.2g} degrees"
        spots.append(Spot(what, found.sharpest))
    return mesh_picture(bag, path, spots)


def drawn(plan: InflationPlan) -> partial[Path] | None:
    """`picture` of a user's mesh, None of other bags."""
    return partial(picture, plan) if isinstance(plan.bag, MeshBag) else None
