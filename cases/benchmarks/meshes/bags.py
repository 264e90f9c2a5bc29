"""The pancake's shape from an STL soup against splines: pressure and height at equal volumes.

Splines have twice the rows of the shipped pancake; both runs have the same flow and time steps.
"""

from __future__ import annotations

import numpy as np

from shells.surfaces.local_elements import lattice

from ..pancake.suite import VOLUMES, BagRun, simulate
from ..report import Row

DOUBLED = ("mesh.rim=8", "mesh.fillet=4", "mesh.flat_max=1.5", "mesh.pole=1.0")
END = 2.99  # V/V0 from which the bag only comes to rest


def bag_rows(quick: bool) -> list[Row]:
    """Rows of both runs; none where only coarse meshes are asked for, as each takes minutes."""
    if quick:
        return []
    splines, triangles = simulate("pancake", DOUBLED), simulate("bag-stl")
    shared = {
        "rejected": triangles.outcome.counts["rejected"],
        "assemblies/step": triangles.per_step("assemblies"),
        "zeta": _zeta(triangles),
        "unknowns": 3 * triangles.body.n_membrane,
        "elements": sum(part.n_elements for part in triangles.body.parts),
        "ratio": triangles.seconds / splines.seconds,
        "peer": "splines with twice the rows of the pancake",
    }
    rows: list[Row] = []
    for volume in (*VOLUMES, None):
        (p, z), (q, y) = (_at(run, volume) for run in (splines, triangles))
        row = {
            "case": "pancake from STL, " + (f"V/V0 = {volume:g}" if volume else "at the end"),
            "seconds": triangles.seconds,
            "error": abs(q / p - 1.0),
            "height error": abs(y / z - 1.0),
            "reference": "pressure of splines with twice the rows of the pancake",
        }
        rows.append(row if volume else {**row, **shared})
    return rows


def _at(run: BagRun, volume: float | None) -> tuple[float, float]:
    """Pressure and height at V/V0, or at the end."""
    v, p = run.history.column("volume"), run.history.column("pressure")
    heights = np.array([_height(run, s.coefficients) for s in run.history.states])
    if volume is None:
        return float(p[-1]), float(heights[-1])
    rising = slice(0, int(np.argmax(v > END * v[0])) + 1)
    ratio = v[rising] / v[0]
    return float(np.interp(volume, ratio, p[rising])), float(
        np.interp(volume, ratio, heights[rising])
    )


def _height(run: BagRun, coefficients: np.ndarray) -> float:
    xi, eta, _ = lattice(run.body.membrane.shape, 8)
    return float(
        (run.body.membrane.sample(xi, eta) @ coefficients[: run.body.n_membrane])[:, 2].max()
    )


def _zeta(run: BagRun) -> float:
    h = run.history
    return float((np.abs(h.column("zeta")[1:]) / h.column("velocity_max")[1:]).max())
