"""What the tolerance of a flow comes to on its surface: budget, orders, compression."""

from __future__ import annotations

from dataclasses import replace

from ..accuracy import Budget, budget
from ..layers.choice import Compression, choose, sharper
from ..near.facing_gap import FacingGap
from ..surfaces.narrowest_gap import largest_extent, narrowest
from ..surfaces.patches import SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface
from .admissible import check_gap
from .mesh_share import film_ratio

TIGHTER = 0.1  # of the matrix tolerance, where corrections do not converge


def flow_budget(surface: SampledSurface, facing: FacingGap | None, tolerance: float) -> Budget:
    """Budget in the narrowest gap: of samples, or the true one where that is thinner.

    Parameters
    ----------
    surface : SampledSurface
    facing : FacingGap or None
        Its closest facing points.
    tolerance : float
        Relative error asked of the traction.

    Returns
    -------
    Budget

    Raises
    ------
    ValueError
        A gap that rounding of the coordinates hides, or a tolerance outside (0, 1).
    """
    gap, film = narrowest(surface), film_ratio(facing)
    distance, extent = gap.distance, gap.extent
    # between samples a curved gap is wider than it is
    if facing is not None and film > 0.0:
        # no film is longer than the body; between flat facets only rounding bounds its length
        length = min(facing.film_length, largest_extent(surface))
        if facing.distance < 2.0 * length * gap.thinness:
            distance, extent = facing.distance, length
    found = budget(tolerance, distance, extent, film)
    check_gap(surface, distance, tolerance)
    return found


def flow_orders(asked: Budget, compression: str) -> QuadratureOrders:
    """Orders of a budget; cross approximation needs one set of points, the finer one."""
    orders = asked.orders
    return replace(orders, outer=orders.source, far=0) if compression == "aca" else orders


def flow_compression(
    method: str, asked: Budget, patches: SurfacePatches, orders: QuadratureOrders, corrected: bool
) -> Compression | None:
    """Compression of the single layer: looser where exact sums are to correct every solve."""
    sizes = {
        "n_dofs": patches.n_dofs,
        "n_outer": patches.n_elements * orders.outer**2,
        "n_source": patches.n_elements * orders.source**2,
    }
    loose = choose(method, asked.corrected, **sizes) if corrected else None
    if loose is not None and sharper(loose, **sizes) is None:
        return loose
    return choose(method, asked.compression, **sizes)
