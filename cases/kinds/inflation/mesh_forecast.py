"""Forecast of a bag from a user's mesh: what the file held, what was mended, where to look."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...geometry.meshes.findings import findings
from ...geometry.meshes.mesh_bag import MeshBag
from ...output.forecast import Item
from .plan import InflationPlan

Findings = tuple[list[Item], list[str]]
THIN = 0.02  # distance of facing sheets over the extent below which films are hard to resolve


def users_mesh(plan: InflationPlan) -> Findings:
    """Items and warnings of a user's mesh; nothing for other bags."""
    bag = plan.bag
    if not isinstance(bag, MeshBag):
        return [], []
    groups = bag.mesh.facets.groups
    items = [
        Item("mesh", len(bag.mesh.control), "", "triangles after repairs and splits"),
        *(Item(f"group {name}", len(of), "", "triangles") for name, of in groups.items()),
        Item("nearest facing sheets", bag.narrowest, "", f"sampled; 2 V / A = {bag.gap:.3g}"),
        Item("largest kink", _largest_kink(bag), "deg", "between triangles; free of stress"),
    ]
    found = [one.text for one in findings(bag.mesh) if one.warns]
    return items, list(dict.fromkeys([*bag.warnings, *found, *_film(plan, bag)]))


def told(plan: InflationPlan) -> tuple[str, ...]:
    """What was read, mended and found, one line each."""
    bag = plan.bag
    if not isinstance(bag, MeshBag):
        return bag.notes
    return (*bag.notes, *(one.text for one in findings(bag.mesh) if not one.warns))


def _largest_kink(bag: MeshBag) -> float:
    """Largest angle between neighbouring triangles of the membrane, degrees."""
    from shells.energy.kinks.edge_geometry import kink_angles

    angles = kink_angles(bag.membrane, bag.coefficients[: bag.n_membrane])
    return float(np.degrees(np.abs(angles).max()))


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
    spots = [
        Spot(one.text.partition(":")[0].partition(",")[0], where)
        for one in findings(bag.mesh)
        for where in (one.places if one.warns else ())
    ]
    return mesh_picture(bag, path, spots)


def drawn(plan: InflationPlan) -> partial[Path] | None:
    """`picture` of a user's mesh, None of other bags."""
    return partial(picture, plan) if isinstance(plan.bag, MeshBag) else None
