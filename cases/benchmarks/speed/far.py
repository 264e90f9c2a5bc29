"""Far field: products of point clouds in CPU seconds, and one solve of a bag by the wall.

Nothing here is used that an older tree lacks.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from cases.benchmarks.compression.suite import CLOUDS
from cases.geometry.pillows.pillow import round_bag
from hbem.accuracy import budget
from hbem.compression.h2matrix import h2matrix
from hbem.compression.operator import direct
from hbem.compression.point_kernel import PointKernel
from hbem.layers.choice import Compression
from hbem.layers.compressed_layer import compressed_single_layer
from hbem.near.near_field import near_field
from hbem.solvers.saddle import IterativeSaddle
from hbem.solvers.saddle_system import SaddleSystem
from hbem.solvers.schwarz import two_level_schwarz
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

TRACTION, RESIDUAL = 1e-3, 1e-6
SMALL = 20  # elements around of a bag that compiles or loads the kernels


def _timed(
    work: Callable[[], Any], clock: Callable[[], float] = time.thread_time
) -> tuple[float, Any]:
    began = clock()
    found = work()
    return clock() - began, found


def cloud(name: str, n: int, tolerance: float, repeats: int = 5) -> dict[str, Any]:
    """H2 product of n points: the least seconds, build (its check included), bytes, error."""
    h2matrix(CLOUDS[name](3000), tolerance)
    points = CLOUDS[name](n)
    build, operator = _timed(lambda: h2matrix(points, tolerance))
    x = np.random.default_rng(1).standard_normal((points.shape[0], 3, 1))
    product = min(_timed(lambda: operator.apply(x))[0] for _ in range(repeats))
    found = operator.statistics
    return {
        "case": f"{name}, h2",
        "N": points.shape[0],
        "tolerance": tolerance,
        "seconds": product,
        "build": build,
        "bytes": found.bytes_far + found.bytes_near,
        "error": found.achieved,
    }


def peer(name: str, n: int, tolerance: float) -> dict[str, Any]:
    """The same product by FMM3D; seconds are not a number where it is not installed."""
    points = CLOUDS[name](n)
    n = points.shape[0]
    row = {"case": f"{name}, FMM3D", "N": n, "tolerance": tolerance}
    try:
        import fmm3dpy
    except ImportError:
        return row | {"seconds": np.nan, "error": np.nan, "note": "not measured: no fmm3dpy"}
    f, x = np.random.default_rng(1).standard_normal((3, n)), np.ascontiguousarray(points.T)
    runs = [
        _timed(lambda: fmm3dpy.stfmm3d(eps=tolerance, sources=x, stoklet=f, ifppreg=1))
        for _ in range(2)
    ]
    some = np.random.default_rng(0).permutation(n)[:200]
    exact = direct(PointKernel(points), None).exact_rows(some, f.T[:, :, None])[:, :, 0]
    given = runs[0][1].pot.reshape(3, n)[:, some].T
    given = given * (np.vdot(given, exact) / np.vdot(given, given))  # normalisations differ
    error = float(np.linalg.norm(given - exact) / np.linalg.norm(exact))
    return row | {"seconds": min(seconds for seconds, _ in runs), "error": error}


def solve(around: int, gap: float) -> dict[str, Any]:
    """One solve of a round bag, part by part; ``around`` elements along its rim."""
    _solve(SMALL, gap)
    return _solve(around, gap)


def _wall(work: Callable[[], Any]) -> tuple[float, Any]:
    return _timed(work, time.perf_counter)


def _solve(around: int, gap: float) -> dict[str, Any]:
    bag, orders = round_bag(around, gap=gap), QuadratureOrders()
    asked = budget(TRACTION, bag.gap, bag.extent).compression["h2"]
    surface = sample(bag.surface, bag.coefficients, orders)
    near_seconds, near = _wall(lambda: near_field(surface, orders))
    build, layer = _wall(lambda: compressed_single_layer(surface, near, Compression("h2", asked)))
    made = SaddleSystem(layer, surface.constraint, surface.mass)
    schwarz_seconds, schwarz = _wall(lambda: two_level_schwarz(made))
    system = IterativeSaddle(
        layer,
        surface.constraint,
        surface.mass,
        tolerance=RESIDUAL,
        preconditioner=lambda _: schwarz,
    )
    data = surface.project(surface.outer.points * [1.0, 1.0, -2.0]).ravel()
    gmres, solved = _wall(lambda: system.solve(data))
    product = min(_wall(lambda: layer @ data)[0] for _ in range(3))
    found = layer.plain.statistics
    return {
        "case": f"solve, thinness {gap:g}, h2",
        "unknowns": layer.shape[0],
        "tolerance": asked,
        "seconds": near_seconds + build + schwarz_seconds + gmres,
        "near": near_seconds,
        "build": build,
        "preconditioner": schwarz_seconds,
        "gmres": gmres,
        "product": product,
        "iterations": solved.iterations,
        "residual": solved.residual,
        "error": found.achieved,
        "bytes": found.bytes_far + found.bytes_near + near.nbytes + schwarz.nbytes,
        "peak GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
    }
