"""What a scene comes to, worked out once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from coupling.schemes.contraction import contraction_forecast
from hbem.accuracy import Budget, budget
from hbem.compression.choice import Compression, choose
from hbem.surfaces.quadrature import QuadratureOrders

from ...geometry.bag import Bag
from ...machine import memory_bytes
from .config import Scene
from .initial_bag import initial_bag

MEMORY_SHARE = 0.8  # of the machine's memory a compressed operator may take


def contraction(scene: Scene, body: Bag | None = None) -> float:
    """Contraction rho of plain subiterations at the scene's time step, before any work."""
    body = initial_bag(scene) if body is None else body
    return contraction_forecast(
        scene.fluid.mass_ratio,
        scene.time.dt,
        element_size=_element_size(body),
        gap=body.gap,
        extent=body.extent,
    )


def fluid_budget(scene: Scene, body: Bag | None = None) -> Budget:
    """Tolerances of the boundary integrals from the scene's traction error and narrowest gap."""
    body = initial_bag(scene) if body is None else body
    return budget(scene.fluid.tolerance, body.gap, body.extent)


def quadrature(scene: Scene, asked: Budget) -> QuadratureOrders:
    """Orders of the budget, or those that the scene insists on."""
    f = scene.fluid
    radial, angular = f.polar if any(f.polar) else (asked.orders.radial, asked.orders.angular)
    far = max(3, f.outer_points, asked.orders.far)
    return replace(
        asked.orders,
        # cross approximation needs one set of points
        outer=far if f.compression == "aca" else f.outer_points,
        far=far,
        radial=radial,
        angular=angular,
        near_ball=f.near_ball,
    )


def compression(scene: Scene, body: Bag, asked: Budget) -> Compression | None:
    """How the single layer is compressed; None where it is stored or summed directly."""
    orders = quadrature(scene, asked)
    elements = body.membrane.n_elements + body.patch.n_elements
    method = scene.fluid.compression
    if method == "auto" and scene.fluid.solver == "lu":
        method = "dense"
    return choose(
        method,
        asked.compression,
        n_dofs=body.membrane.n_dofs + body.patch.n_dofs,
        n_outer=elements * orders.outer**2,
        n_source=elements * orders.source**2,
        memory=MEMORY_SHARE * memory_bytes() or None,
        seed=scene.output.seed,
    )


def _element_size(body: Bag) -> float:
    """Square root of the smallest membrane element's area, poles left out."""
    middle = np.array([0.5])
    s, t = (body.membrane.sample(middle, middle, k) for k in (0, 1))
    c = body.coefficients[: body.n_membrane]
    area = np.linalg.norm(np.cross(s @ c, t @ c), axis=1)
    return float(np.sqrt(area.min()))
