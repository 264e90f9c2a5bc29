"""Dense plain part, patch blocks and coarse image: CPU seconds beside the limit of the machine.

Nothing here is used that an older tree lacks. A pair is one target with one source, those that
symmetry spares included.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from cases.geometry.pillows.pillow import round_bag
from hbem.layers.dense_layer import dense_matrix
from hbem.layers.direct_layer import DirectSingleLayer
from hbem.layers.point_sums import single_layer_sums
from hbem.near.near_field import near_field
from hbem.solvers.coarse_level import apply_to_coarse_space, bisect
from hbem.solvers.saddle_system import SaddleSystem
from hbem.solvers.schwarz import (
    Functions,
    SchwarzOptions,
    coarse_space,
    subdomains_around,
    two_level_schwarz,
)
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

DENSE = {"pancake's size": 20, "1000 elements": 44}  # elements around
LARGE = 102  # elements around of 5202
REPEATS = 5


def layer(around: int) -> DirectSingleLayer:
    """The single layer of a bag of gap over extent .05, of ``around**2 / 2`` elements."""
    bag, orders = round_bag(around, gap=0.05), QuadratureOrders()
    surface = sample(bag.patches(), bag.coefficients, orders)
    return DirectSingleLayer(surface, near_field(surface, orders))


def limit(n: int = 4000) -> float:
    """Seconds a pair of the plainest sum: one strength, no functions."""
    rng = np.random.default_rng(0)
    x, y, f = (rng.random((n, 3)) for _ in range(3))
    return _least(lambda: single_layer_sums(x, y, f), REPEATS) / n**2


def figures(quick: bool = False) -> dict[str, dict[str, float]]:
    """Least CPU seconds of each work, seconds a pair and the limit."""
    found: dict[str, dict[str, float]] = {"limit": {"s/pair": limit()}}
    for name, around in DENSE.items():
        small = layer(around)
        pairs = small.surface.outer.weights.size * small.surface.source.weights.size
        seconds = _least(lambda one=small: dense_matrix(one.surface, one.near), REPEATS)
        found[name] = {"dense matrix": seconds, "s/pair": seconds / pairs}
    large = layer(DENSE["1000 elements"] if quick else LARGE)
    options, functions = SchwarzOptions(), Functions.of(large.surface)
    clusters = bisect(functions.positions, options.own)
    around_each = subdomains_around(functions, clusters, options.overlap)
    coarse = coarse_space(functions, clusters)
    system = SaddleSystem(large, large.surface.constraint, large.surface.mass)
    columns = system.columns.shape[1]
    found[f"{large.surface.patches.n_elements} elements"] = {
        "patch blocks": _least(lambda: large.blocks(around_each, lambda k, block: block[:1])),
        "coarse image": _least(lambda: apply_to_coarse_space(large, coarse)),
        "preconditioner": _least(lambda: two_level_schwarz(system)),
        "unknowns": large.shape[0] + columns,
    }
    return found


def _least(run: Callable[[], object], repeats: int = 2) -> float:
    """Least CPU seconds of all threads."""
    run()
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        run()
        best = min(best, time.process_time() - start)
    return best
