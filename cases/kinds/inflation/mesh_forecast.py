"""Forecast of a bag from a user's mesh: what the file held, what was mended, where to look."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...geometry.bag_sampler import triangulated
from ...geometry.inspection import stretches
from ...geometry.meshes.findings import findings
from ...geometry.meshes.mesh_bag import MeshBag
from ...output.forecast import Item
from .initial_bag import nature
from .mesh_config import MeshGeometry
from .plan import InflationPlan

Findings = tuple[list[Item], list[str]]
WARNING = "warning: "  # how notes of repairs begin that should be acted upon
CREASE = 5.0  # degrees; below, creases keep almost all edges of a curved surface sharp
TORN = 1.9  # stretch against a reference that no cloth has: a unit is another, or the numbering
CELLS = 3  # per side of a triangle, of the test for crossings
FACETS = 1e-9  # distance from the facets, of the extent
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
    cautions: list[str] = []
    for more, wrong in (_unfolded(plan, bag), _crossing(bag)):
        items += more
        cautions += wrong
    mended = [note.removeprefix(WARNING) for note in bag.notes if note.startswith(WARNING)]
    found = [one.text for one in findings(bag.mesh) if one.warns]
    cautions += [*_film(plan, bag), *_facets(plan, bag)]
    return items, list(dict.fromkeys([*mended, *bag.warnings, *found, *cautions]))


def _unfolded(plan: InflationPlan, bag: MeshBag) -> Findings:
    """How the bag is stretched against a reference that is not folded into it."""
    if bag.flat is None or bag.folding is not None:
        return [], []
    found = stretches(bag)
    state = nature(plan.scene, bag)
    what = "the stress-free bag" if state == "flat" else f"not free of stress: {state!r}"
    note = f"down to {found[0]:.3g}; 98% in {found[1]:.3g} .. {found[2]:.3g}; {what}"
    items = [Item("stretch of reference", found[3], "", note)]
    if found[1] > 1.0 / TORN and found[2] < TORN:
        return items, []
    return items, [
        f"98% of the bag is stretched by {found[1]:.3g} to {found[2]:.3g} against its unfolded "
        "reference: save both from one mesh in one unit, or drop geometry.reference"
    ]


def _crossing(bag: MeshBag) -> Findings:
    """Whether the bag crosses itself and what its inlet faces; folded ones say it anyway."""
    if bag.folding is not None:
        return [], []
    crosses = triangulated(bag, CELLS).intersects(bag.coefficients)
    items = [
        Item("inlet faces", bag.faces if np.isfinite(bag.faces) else "nothing", "", "outward"),
        Item("self-intersections", "YES" if crosses else "none", "", "of the sampled bag"),
    ]
    if not crosses:
        return items, []
    return items, [
        "the bag crosses itself, and runs refuse to start from there: mend it in a mesh tool, or "
        "leave its inner parts out by geometry.rest"
    ]


def told(plan: InflationPlan) -> tuple[str, ...]:
    """What was read, mended and found, one line each."""
    bag = plan.bag
    if not isinstance(bag, MeshBag):
        return bag.notes
    notes = (note for note in bag.notes if not note.startswith(WARNING))
    return (*notes, *(one.text for one in findings(bag.mesh) if not one.warns))


def _largest_kink(bag: MeshBag) -> float:
    """Largest angle between neighbouring triangles of the membrane, degrees."""
    from shells.energy.kinks.edge_geometry import kink_angles

    angles = kink_angles(bag.membrane, bag.coefficients[: bag.n_membrane])
    return float(np.degrees(np.abs(angles).max()))


def _facets(plan: InflationPlan, bag: MeshBag) -> list[str]:
    """Flat triangles in a flow, where smooth ones were to be had."""
    g = plan.scene.geometry
    kept = isinstance(g, MeshGeometry) and not (g.smooth and g.crease >= CREASE)
    if not (plan.has_flow and kept and bag.mesh.moved < FACETS * bag.extent):
        return []
    return [
        "the surface is flat facets: the traction is singular at their edges, and the drag of a "
        "sphere of 200 is 2 % off; set geometry.smooth and geometry.crease = 30, or run with "
        "fluid.model = 'pressure'"
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
    spots = [
        Spot(one.text.partition(":")[0].partition(",")[0], where)
        for one in findings(bag.mesh)
        for where in (one.places if one.warns else ())
    ]
    return mesh_picture(bag, path, spots)


def drawn(plan: InflationPlan) -> partial[Path] | None:
    """`picture` of a user's mesh, None of other bags."""
    return partial(picture, plan) if isinstance(plan.bag, MeshBag) else None
