"""Scaling on accordions: one fluid solve of bags folded n = 2, 4, 8, 16 times.

Pillow bags at one element a fold radius, panels of ten radii, gap 0.4 radii, whose sheets approach
at a linear velocity. Near field, compression, preconditioner and GMRES apart, with memory, near
pairs a point, the traction error that compression and Krylov leave (a second solve, against a
manufactured film traction and against a dense matrix where that fits), and growth exponents in the
number of unknowns from row to row.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.sparse.linalg import aslinearoperator

from hbem.layers.choice import Compression
from hbem.layers.dense_layer import dense_matrix
from hbem.layers.layer import SingleLayer
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import IterativeSaddle, SaddleSolution

from ...geometry.pillows.pillow import accordion
from ..compression.bags import fluid_solve, manufactured, strain
from ..integrals.gaps import relative
from ..report import Row
from .growth import growth

PANEL, GAP = 10.0, 0.4  # fold radii
# measured on two folds: 1e-4 leaves tractions wrong by 3.8e-3
TOLERANCE = 1e-5
EXACT = 100_000  # unknowns up to which exact sums check the traction; 16 folds would take 8 minutes
DENSE = 25_000  # unknowns up to which a dense matrix is solved beside
DENSE_QUICK = 10_000  # the same of ``--quick``: the larger one takes ten minutes
DENSE_TOLERANCE = 1e-9  # by GMRES: OpenBLAS' LU of 23000 unknowns crashed


def elements_around(folds: int) -> int:
    """Elements around for one a fold radius: ``314 (folds + 1)^2`` quadrilaterals in all."""
    return 4 * round(0.5 * np.sqrt(0.5 * 314.0) * (folds + 1))


def _row(
    folds: int, compression: Compression | None
) -> tuple[Row, SingleLayer, tuple[SaddleSolution, IterativeSaddle]]:
    bag = accordion(elements_around(folds), folds, panel=PANEL, gap=GAP)
    began = time.perf_counter()
    layer = single_layer(bag.surface, bag.coefficients, storage="direct", compression=compression)
    assembled = time.perf_counter() - began
    solved, system, parts = fluid_solve(layer, strain(layer))
    row: Row = {
        "case": f"accordion {folds}, {compression.method if compression else 'direct'}",
        "seconds": assembled + parts["preconditioner"] + parts["gmres"],
        "error": np.nan,
        "folds": folds,
        "quadrilaterals": bag.surface.n_elements,
        "unknowns": layer.shape[0],
        "matrix tolerance": compression.tolerance if compression else 0.0,
        "near pairs/point": layer.n_near / layer.surface.outer.points.shape[0],
    }
    if compression is not None:
        s = layer.plain.statistics
        row |= {
            "near": assembled - s.build_seconds,
            "build": s.build_seconds,
            "bytes/unknown": s.bytes_per_unknown,
            "error random": s.achieved,
        }
    row |= parts
    row["reference"] = "none: exact sums would take longer than the solve"
    if layer.shape[0] <= EXACT:
        data, exact = manufactured(layer)
        solved = system.solve(data)
        row["error"] = relative(layer.surface, solved.solution, exact)
        row["reference"] = (
            f"manufactured traction, data by exact sums; {solved.iterations} iterations"
        )
    row["peak GB so far"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return row, layer, (solved, system)


def _dense_row(
    folds: int, layer: SingleLayer, solved: SaddleSolution, system: IterativeSaddle
) -> Row:
    """The same solve by a dense matrix, and the traction of the compressed one against it."""
    surface, (data, _), began = layer.surface, manufactured(layer), time.perf_counter()
    matrix = dense_matrix(surface, layer.near)
    assembled = time.perf_counter() - began
    dense = replace(system, operator=aslinearoperator(matrix), tolerance=DENSE_TOLERANCE)
    exact = dense.solve(data)
    return {
        "case": f"accordion {folds}, dense beside it",
        "seconds": time.perf_counter() - began,
        "error": relative(surface, solved.solution, exact.solution),
        "folds": folds,
        "unknowns": layer.shape[0],
        "assembly": assembled,
        "iterations": exact.iterations,
        "residual": exact.residual,
        "bytes/unknown": 8.0 * layer.shape[0],
        "reference": "error: traction of the compressed solve against this one",
    }


def run(quick: bool) -> Iterator[Row]:
    """Rows of the ladder, as they come; ``quick`` stops at four folds."""
    compression = Compression("h2", TOLERANCE)
    _row(1, compression)  # compiles the kernels
    rows = []
    for folds in (2, 4) if quick else (2, 4, 8, 16):
        row, layer, solution = _row(folds, compression)
        rows.append(row)
        yield row
        if row["unknowns"] <= (DENSE_QUICK if quick else DENSE):
            yield _dense_row(folds, layer, *solution)
        del layer, solution
    yield from growth(rows)
