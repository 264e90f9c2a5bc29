"""Flows whose tractions are known: inside a torus, in a film between spheres, in a folded bag."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbem.flows.stokes_flow import StokesFlow
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders

from ...geometry.bodies import torus
from ...geometry.pillows.pillow import accordion
from ..honesty.flows.exact import approaching
from ..honesty.flows.fields import FIELDS
from ..honesty.flows.spheres import bodies, moving
from ..meshes.flow import relative_distance, stokeslet, stokeslet_traction
from ..report import Row
from .bags import row

GAP = 0.1  # between the spheres, in radii
RULES = {
    "default": QuadratureOrders(),
    "fine": QuadratureOrders.fine(),
    "far 4": QuadratureOrders(far=4),
    "outer 2": QuadratureOrders(outer=2),
    "near 4 + 2 ln(1/b)": QuadratureOrders(near_offset=4.0, near_slope=2.0),
}
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4)


@dataclass(frozen=True)
class Problem:
    """A body of some size and degree, and the error of a flow about or within it."""

    name: str
    reference: str
    body: Callable[[int, int], BezierPatches]
    sizes: tuple[int, ...]
    chosen: int  # what a user would begin with, degree 2
    error: Callable[[StokesFlow], float]
    options: dict[str, Any]
    degrees: tuple[int, ...] = (2, 3)

    def rows(self, quick: bool) -> Iterator[Row]:
        """By mesh for each degree, then by tolerance and rule on the finest mesh."""
        sizes = self.sizes[:2] if quick else self.sizes
        finest = sizes[-1], self.degrees[-1]
        for degree in self.degrees:
            for n in sizes:
                default = (degree, n) == (2, min(self.chosen, sizes[-1]))
                yield self.row(f"mesh, degree {degree}", f"{n}", n, degree, default=default)
        for tolerance in TOLERANCES:
            yield self.row("tolerance, finest mesh", f"{tolerance:g}", *finest, tolerance=tolerance)
        for name, orders in RULES.items():
            yield self.row("rule, finest mesh", name, *finest, orders=orders)

    def row(
        self, family: str, setting: str, n: int, degree: int, *, default: bool = False, **asked: Any
    ) -> Row:
        """One flow: seconds from the mesh to the traction, as a user waits for them."""
        body = self.body(n, degree)
        start = time.perf_counter()
        flow = StokesFlow(body, **{"measure": "operator", **self.options, **asked})
        error = self.error(flow)
        seconds = time.perf_counter() - start
        return row(self.name, family, setting, seconds, error, self.reference, default)


def _inside(flow: StokesFlow) -> float:
    """Traction of a Stokeslet's flow within a body: exact on any geometry."""
    found, surface = flow.traction(stokeslet).values, flow.surface.outer
    exact = stokeslet_traction(surface.points, surface.normals)
    level = surface.weights @ np.sum((exact - found) * surface.normals, axis=1)
    exact -= level / surface.weights.sum() * surface.normals
    return relative_distance(flow.surface, found, exact)


def _approaching(flow: StokesFlow) -> float:
    """Force of two spheres that approach each other, against its series."""
    forces = flow.traction(moving("approaching", GAP)).force()[:, 2]
    return float(np.abs(np.abs(forces) / (6.0 * np.pi * approaching(GAP)) - 1.0).max())


def power(flow: StokesFlow) -> float:
    """Power of the flow in a bag that is squeezed."""
    velocity = FIELDS["squeeze"](flow.points)
    traction = flow.traction(FIELDS["squeeze"]).values
    return float(flow.weights @ np.sum(velocity * traction, axis=1))


def problems(quick: bool) -> Iterator[Problem]:
    """The three, ``quick`` with a coarser reference for the last."""
    yield Problem(
        "torus flow",
        "a Stokeslet outside",
        lambda n, degree: torus(n, 2 * n, minor=0.5, major=1.5, degree=degree),
        (4, 6, 8, 12, 16),
        8,
        _inside,
        {"viscosity_ratio": 0.0},
    )
    yield Problem(
        "thin film",
        "bispherical series",
        lambda n, degree: bodies(n, 6, GAP, 4.0 / n, degree=degree),
        (8, 10, 14, 20),
        10,
        _approaching,
        {},
    )

    def bag(n: int, degree: int) -> BezierPatches:
        return accordion(n, 2).patches()

    finest = power(StokesFlow(bag(36 if quick else 72, 2), tolerance=1e-4, measure="operator"))
    yield Problem(
        "folded bag",
        "power on a finer mesh, for 1e-4",
        bag,
        (20, 28, 36, 44),
        28,
        lambda flow: abs(power(flow) / finest - 1.0),
        {},
        degrees=(2,),
    )
