"""Compressed Stokes operators against direct sums and FMM3D, then full operators of bags.

Rows: N points on a sphere and on a stack of ten flat layers with gaps of 0.01 at 1e-3 and 1e-6:
build, apply, bytes, measured error; FMM3D (its wheel is a generic x86-64 build: a native one
is faster) and the direct sum in the same run, all on one thread; ``threads ratio`` is one
thread's application over that of all. Then Galerkin operators of bags: `compressed_bags`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hbem._threads_kernels import limited
from hbem.compression.h2matrix import h2matrix
from hbem.compression.hmatrix import forecast_points, hmatrix
from hbem.compression.operator import Compressed, direct
from hbem.compression.point_kernel import PointKernel

from ..report import Row
from . import bags as compressed_bags

TOLERANCES = (1e-3, 1e-6)
MEMORY = 3.0e9  # bytes an operator of this benchmark may take
LARGEST_FINE = 100_000  # points up to which both tolerances run
DIRECT = 3000  # targets of a timed direct sum; the rest is extrapolated
BUILDERS: dict[str, Callable[[np.ndarray, float], Compressed]] = {"aca": hmatrix, "h2": h2matrix}


def sphere(n: int) -> np.ndarray:
    """Fibonacci points on the unit sphere."""
    k = np.arange(n) + 0.5
    z, phi = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def stack(n: int, layers: int = 10, gap: float = 0.01) -> np.ndarray:
    """About n points on parallel unit squares, exactly coplanar in each layer."""
    m = round(np.sqrt(n / layers))
    x, y = (g.ravel() for g in np.meshgrid(*[(np.arange(m) + 0.5) / m] * 2, indexing="ij"))
    return np.concatenate([np.stack([x, y, np.full(m * m, k * gap)], 1) for k in range(layers)])


CLOUDS: dict[str, Callable[[int], np.ndarray]] = {"sphere": sphere, "stack": stack}


def pairs() -> int:
    """Calibration: a direct sum."""
    points = sphere(2000)
    PointKernel(points).rows(np.arange(2000), np.ones((1, 3, 2000)))
    return 2000**2


def _timed(function: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Shortest wall time and the last result."""
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        result = function()
        best = min(best, time.perf_counter() - began)
    return best, result


def _direct_row(cloud: str, points: np.ndarray) -> Row:
    operator = direct(PointKernel(points), None)
    n = points.shape[0]
    some = np.arange(0, n, -(-n // DIRECT))
    seconds, _ = _timed(lambda: operator.exact_rows(some, np.ones((n, 3, 1))), 2)
    return {
        "case": f"{cloud}, direct sum",
        "seconds": seconds * n / some.size,
        "error": 0.0,
        "N": n,
        "reference": f"timed on {some.size} targets",
    }


def _fmm_row(cloud: str, points: np.ndarray, tolerance: float) -> Row | None:
    try:
        import fmm3dpy
    except ImportError:
        return None
    n = points.shape[0]
    f, x = np.random.default_rng(1).standard_normal((3, n)), np.ascontiguousarray(points.T)
    seconds, found = _timed(
        lambda: fmm3dpy.stfmm3d(eps=tolerance, sources=x, stoklet=f, ifppreg=1),
        2 if n < 200_000 else 1,
    )
    some = np.random.default_rng(0).permutation(n)[:200]
    exact = direct(PointKernel(points), None).exact_rows(some, f.T[:, :, None])[:, :, 0]
    given = found.pot.reshape(3, n)[:, some].T / (8.0 * np.pi)
    given = given * (np.vdot(given, exact) / np.vdot(given, given))  # normalisations differ
    return {
        "case": f"{cloud}, FMM3D (generic wheel)",
        "seconds": seconds,
        "error": float(np.linalg.norm(given - exact) / np.linalg.norm(exact)),
        "N": n,
        "tolerance": tolerance,
        "reference": "exact sums at 200 points",
    }


def _compressed_row(
    cloud: str,
    method: str,
    points: np.ndarray,
    tolerance: float,
    peer: Row,
    threads: int,
) -> Row:
    began = time.perf_counter()
    operator: Compressed = BUILDERS[method](points, tolerance)
    total = time.perf_counter() - began
    x = np.random.default_rng(1).standard_normal((points.shape[0], 3, 1))
    seconds, _ = _timed(lambda: operator.apply(x))
    with limited(threads):
        together, _ = _timed(lambda: operator.apply(x))
    s = operator.statistics
    return {
        "case": f"{cloud}, {method}",
        "seconds": seconds,
        "error": s.achieved,
        "N": points.shape[0],
        "tolerance": tolerance,
        "build": s.build_seconds,
        "build and check": total,
        "bytes/unknown": s.bytes_per_unknown,
        "rank": s.rank_mean,
        "rank max": s.rank_max,
        "ratio": peer["seconds"] / seconds,
        "threads ratio": seconds / together,
        "build/peer": s.build_seconds / peer["seconds"],
        "peer": peer["case"].split(", ")[1],
        "reference": "exact rows, random and constant densities",
        "note": s.note,
    }


def _point_rows(sizes: tuple[int, ...], threads: int) -> Iterator[Row]:
    first: dict[tuple[str, float], float] = {}  # bytes an unknown of the smallest cloud
    for cloud, make in CLOUDS.items():
        for n in sizes:
            points = make(n)
            exact = _direct_row(cloud, points)
            yield exact
            for tolerance in TOLERANCES if n <= LARGEST_FINE else TOLERANCES[:1]:
                peer = _fmm_row(cloud, points, tolerance)
                if peer is not None:
                    yield peer
                for method in BUILDERS:
                    if method == "aca" and forecast_points(points, tolerance) > MEMORY:
                        continue  # more memory than the benchmark may take; h2 has a row
                    row = _compressed_row(cloud, method, points, tolerance, peer or exact, threads)
                    growth = first.setdefault((row["case"], tolerance), row["bytes/unknown"])
                    yield row | {"growth": row["bytes/unknown"] / growth}


def run(quick: bool) -> Iterator[Row]:
    """Rows of the benchmark, as they come; ``quick`` takes the smallest sizes."""
    for build in BUILDERS.values():  # compiles the kernels
        for tolerance in TOLERANCES:
            build(sphere(2000), tolerance)
    sizes = (10_000,) if quick else (10_000, 30_000, 100_000, 300_000)
    with limited(1) as threads:
        yield from _point_rows(sizes, threads)
    yield from compressed_bags.rows(quick)


def draw(rows: list[Row], path: Path) -> None:
    """Apply, build and bytes against N, log-log, with slopes of N, N log N and N^2."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    shown = ("seconds", "build", "bytes/unknown")
    titles = ("one application [s]", "build [s]", "bytes an unknown")
    figure, axes = plt.subplots(1, 3, figsize=(15, 5), layout="constrained")
    lines: dict[tuple[str, float], list[Row]] = {}
    for row in rows:
        if "N" in row:
            lines.setdefault((row["case"], row.get("tolerance", 0.0)), []).append(row)
    for axis, key, title in zip(axes, shown, titles, strict=True):
        for (case, tolerance), line in lines.items():
            found = [(r["N"], r[key]) for r in line if r.get(key)]
            if found:
                label = f"{case} {tolerance:g}" if tolerance else case
                style = "--" if "stack" in case else "-"
                axis.loglog(*zip(*found, strict=True), style, marker="o", ms=3, label=label)
        n = np.array(sorted({r["N"] for line in lines.values() for r in line}), dtype=float)
        low = min(r[key] for line in lines.values() for r in line if r.get(key))
        if key != "bytes/unknown":
            for name, growth in (("N", n), ("N log N", n * np.log(n)), ("N^2", n**2)):
                axis.loglog(n, 0.7 * low * growth / growth[0], ":", color="0.5", lw=1)
                axis.annotate(name, (n[-1], 0.7 * low * growth[-1] / growth[0]), fontsize=8)
        axis.set(title=title, xlabel="N points")
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=7)
    figure.savefig(path, dpi=120)
    plt.close(figure)
