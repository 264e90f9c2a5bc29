"""`StokesFlow` on thin bodies against the finest rule on the same mesh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hbem.flows.stokes_flow import StokesFlow
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders

from ....geometry.bodies import spheroid
from ....geometry.pillows.pillow import round_bag
from .fields import FIELDS, Trial, announced, away, resolves

# Two, and the error is the distance to the nearer: beside the collapsed corners of a bag they
# differ by 1e-5 of the traction at thinness .01 and 1e-4 at .005, and neither is better.
FINEST = [
    QuadratureOrders(far=12, near_offset=offset, near_slope=5.0, radial=24, angular=24)
    for offset in (18.0, 20.0)
]
THINNESS = (0.1, 0.05, 0.03, 0.02, 0.01, 0.007, 0.005)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
TRIED = ("squeeze", "slide", "tumble", "jet")  # films and others


def trials(quick: bool) -> Iterator[Trial]:
    """Ellipsoids, whose rims are as sharp as their thinness squared, and flat bags."""
    if quick:
        yield from _trials("ellipsoid .2", _ellipsoid(6, 0.2, 4), (1e-3,), TRIED[:2])
        yield from _trials("flat .05", round_bag(8, gap=0.05).patches(), (1e-2,), TRIED[:2])
        return
    for c in THINNESS:
        yield from _trials(f"ellipsoid {c:g}", _ellipsoid(8, c), TOLERANCES, TRIED)
        yield from _trials(f"flat {c:g}", round_bag(16, gap=c).patches(), TOLERANCES, TRIED)


def _ellipsoid(n: int, c: float, around: int | None = None) -> BezierPatches:
    return spheroid(n, around or n, c=c, grading=0.5)


def _trials(
    name: str, body: BezierPatches, tolerances: tuple[float, ...], fields: tuple[str, ...]
) -> Iterator[Trial]:
    finest = [
        StokesFlow(body, orders=orders, compression="dense", measure="none") for orders in FINEST
    ]
    truths = {
        field: [flow.traction(FIELDS[field]).coefficients.ravel() for flow in finest]
        for field in fields
    }
    for tolerance in tolerances:
        flow = StokesFlow(body, tolerance=tolerance, measure="operator")
        for field in fields:
            case = f"{name} for {tolerance:g}, {field}"
            yield {"case": case} | _trial(flow, field, truths[field])


def _trial(flow: StokesFlow, name: str, truths: list[np.ndarray]) -> Trial:
    field, made = FIELDS[name], flow.formulation
    found = flow.traction(field)
    tested = flow.surface.project(field(flow.points)).ravel()
    plain = made.system.solve(made.data(tested))
    measured = flow.solver.decompressed(plain, tested)
    first = flow.solver.refined(measured, tested, rules=1).quadrature[0]
    told = found.error
    return {
        "promise": "quadrature",
        "tolerance": told.tolerance,
        "error": min(away(flow, found.coefficients.ravel(), truth) for truth in truths),
        "refused": announced(told),
        "share": "quadrature",
        "estimate": told.operator + told.krylov,
        "before": first / away(flow, plain.solution, truths[0]),
        "resolved": resolves(flow, told),
    }
