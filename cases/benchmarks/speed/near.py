"""Near field of a round bag: what a kernel point and a near pair cost, all included.

Absolute imports and faces that older trees have too: the suite runs this file under both.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from cases.geometry.pillows.pillow import round_bag
from hbem._threads_kernels import limited
from hbem.near.closest_point import NearPairs, outer_pairs
from hbem.near.near_field import near_field
from hbem.near.near_rules import near_moments
from hbem.surfaces.quadrature import LARGEST, QuadratureOrders
from hbem.surfaces.surface_points import sample

SHARE = 64  # elements whose moments are held at a time


def near_costs(n_s: int, gap: float, repeats: int = 3) -> dict[str, float]:
    """Seconds of the near field's assembly and its parts, counts of pairs and points, rates.

    Parameters
    ----------
    n_s : int
        ``n_s**2 / 2`` elements: 102 for 5202.
    gap : float
        Thickness of the bag over its diameter.
    repeats : int
        The least of so many times is kept.

    Returns
    -------
    dict
        CPU seconds of one thread; ``"two threads"`` is how many times faster these are by the wall.
    """
    bag, orders = round_bag(n_s, gap=gap), QuadratureOrders()
    surface = sample(bag.surface, bag.coefficients, orders)
    points = slice(0, surface.outer.weights.size)
    pairs, step = outer_pairs(surface, orders, points), SHARE * surface.outer.per_element

    def moments() -> None:
        for first in range(0, points.stop, step):
            part = pairs.part(slice(first, min(first + step, points.stop)))
            near_moments(surface, part, orders, minus_plain=True)

    def whole() -> None:
        near_field(surface, orders)

    with limited(1) as before:
        seconds = _least(whole, repeats)
        closest = _least(lambda: outer_pairs(surface, orders, points), repeats)
        integrals = _least(moments, repeats)
        alone = _least(whole, repeats, time.perf_counter)
    with limited(min(2, before)):
        together = _least(whole, repeats, time.perf_counter)
    n = rule_points(pairs, orders)
    return {
        "elements": float(surface.patches.n_elements),
        "pairs": float(pairs.n_pairs),
        "points": n,
        "seconds": seconds,
        "closest points": closest,
        "moments": integrals,
        "ns a point": 1e9 * seconds / n,
        "us a pair": 1e6 * integrals / pairs.n_pairs,
        "two threads": alone / together,
    }


def rule_points(pairs: NearPairs, orders: QuadratureOrders) -> float:
    """Kernel points that the single layer's rules ask for, the plain rule of each pair included."""
    rows, width = pairs.closest.rows, pairs.boxes[:, 1::2] - pairs.boxes[:, ::2]
    relative = np.maximum(np.abs(pairs.closest.distances) / width, 1e-6)
    nodes = np.ceil(rows[:, 4:] * (orders.near_offset - orders.near_slope * np.log(relative)))
    tensor = np.clip(nodes, 4, LARGEST).prod(axis=1)
    polar = 4.0 * orders.radial * orders.angular
    accurate = np.where(pairs.closest.distances[:, 0] < 0.0, polar, tensor)
    return float(accurate.sum() + orders.source**2 * pairs.first.sum())


def _least(
    work: Callable[[], object], repeats: int, clock: Callable[[], float] = time.thread_time
) -> float:
    spent = []
    for _ in range(repeats + 1):  # the first compiles or loads
        began = clock()
        work()
        spent.append(clock() - began)
    return min(spent[1:])
