"""A body of 1e5 unknowns from triangles: forecast of memory and seconds against what they are."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from hbem.flows.stokes_flow import StokesFlow
from hbem.layers.choice import bytes_of, costs_of
from hbem.surfaces.quadrature import QuadratureOrders

from ...kinds.sizes import NEAR_BYTES
from .raw_bodies import raw_sphere

UNKNOWNS = 100_000
PRODUCTS = 20
# Seconds an outer point of one thread: near pairs and their moments, checks of the surface.
NEAR_SECONDS, CHECK_SECONDS = 1.6e-4, 4e-5


def large_row(unknowns: int = UNKNOWNS) -> dict[str, Any]:
    """Drag of a raw sphere with linear densities, without measured errors.

    Two outer points per direction: enough for linear densities on triangles.
    """
    patches = raw_sphere(unknowns // 3).patches()
    orders = QuadratureOrders(outer=2)
    begin = time.perf_counter()
    flow = StokesFlow(patches, tolerance=1e-2, orders=orders, compression="h2", measure="none")
    compression = flow.compression
    assert compression is not None
    points = patches.n_elements * orders.outer**2
    asked = compression.method, compression.tolerance, patches.n_dofs, points, points
    forecast = bytes_of(*asked) + NEAR_BYTES * 3 * patches.n_dofs
    tolerances = {compression.method: compression.tolerance}
    far = costs_of(tolerances, patches.n_dofs, points, points, PRODUCTS)[compression.method]
    expected = far + points * (NEAR_SECONDS + CHECK_SECONDS)
    start = time.perf_counter()
    layer = flow.formulation.layer
    built = time.perf_counter()
    found = flow.traction(np.array([0.0, 0.0, 1.0]))
    end = time.perf_counter()
    stored = float(layer.statistics()["bytes_per_unknown"]) * 3 * patches.n_dofs
    return {
        "case": "large raw sphere, drag, quadratic, density 1",
        "triangles": patches.n_elements,
        "unknowns": 3 * patches.n_dofs,
        "seconds": end - begin,
        "error": float(abs(found.force()[0, 2] / (6.0 * np.pi) - 1.0)),
        "reference": "6 pi",
        "points": points,
        "checks s": start - begin,
        "build s": built - start,
        "solve s": end - built,
        "products": found.iterations,
        "seconds expected": expected,
        "operator GB": (layer.near.nbytes + stored) / 1e9,
        "GB expected": forecast / 1e9,
        "method": f"{compression.method} at {compression.tolerance:.1e}",
    }
