"""Stokes flow beside a uniform pressure: bulge at equal volume, order of unfolding.

A bag that a uniform pressure fills is an elastica until it is nearly full: its ends, where it is
curved, open first and its middle closes, until walls meet [a ring's opposite walls do so below a
quarter of its full area]. Stokes flow fills the middle, which is next to the inlet, first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...kinds.planar.config import FlatCurve
from ...kinds.planar.geometry import pieces
from ..report import Row
from .runs import PlanarRun, simulate, volume_error

SMALL = ("geometry.width=4", "mesh.straight=0.2", "mesh.curved=0.13")
UNIFORM = "fluid.model=pressure"
FINE = 8  # points of an element: chords through the nodes alone would hide small new volumes


def volume_ratio(run: PlanarRun) -> np.ndarray:
    """V/V0 of every step, as far as it grows."""
    v = run.history.column("volume")
    return np.maximum.accumulate(v) / v[0]


def at_volume(run: PlanarRun, ratio: float) -> np.ndarray:
    """Coefficients where the volume first reaches a multiple of the initial one.

    Raises
    ------
    ValueError
        A run that ends before.
    """
    v = volume_ratio(run)
    if v[-1] < ratio:
        raise ValueError(f"{run.scene.name} ends at V/V0 = {v[-1]:g}, below {ratio:g}")
    k = max(1, int(np.searchsorted(v, ratio)))
    s = (ratio - v[k - 1]) / max(v[k] - v[k - 1], 1e-300)
    return (1.0 - s) * run.states[k - 1].coefficients + s * run.states[k].coefficients


def stations(run: PlanarRun) -> list[tuple[int, int]]:
    """Nodes on the right lower and upper sheet that cut the bag: chamber, folds, tips.

    Folded bags are cut at the ends of chamber and first folds, pancakes at a quarter of the width.
    """
    points, shape = run.states[0].coefficients[::2], run.scene.geometry
    if isinstance(shape, FlatCurve):
        right, middle = points[:, 0] - 0.25 * shape.width, len(points) // 2
        low = int(np.argmin(np.abs(right[: middle // 2])))
        return [(low, middle // 2 + int(np.argmin(np.abs(right[middle // 2 : middle]))))]
    ends = np.cumsum(pieces(shape).lengths)
    nodes = run.structure.shell.basis.nodes
    at = [int(np.argmin(np.abs(nodes - end))) for end in ends]
    return [(at[1], at[10]), (at[3], at[8])]


def curve(run: PlanarRun, coefficients: np.ndarray) -> np.ndarray:
    """Points of the membrane, `FINE` an element."""
    xi = np.linspace(0.0, 1.0, FINE, endpoint=False)
    points = run.structure.shell.basis.sample(xi) @ coefficients
    return np.concatenate([points, coefficients[-2:-1]])


def sections(points: np.ndarray, cuts: Sequence[tuple[int, int]]) -> np.ndarray:
    """Areas of a symmetric bag's sections, from the chamber outwards; both sides together."""
    n = points.shape[0]
    beyond = [area(points)]
    for low, up in cuts:
        beyond.append(area(points[low : up + 1]) + area(points[n - 1 - up : n - low]))
    return -np.diff([*beyond, 0.0])


def area(points: np.ndarray) -> float:
    """Of a counterclockwise polygon."""
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def shares(run: PlanarRun, ratio: float) -> np.ndarray:
    """Shares of the new volume in the sections when the whole has grown to ``ratio``."""
    cuts = [(FINE * low, FINE * up) for low, up in stations(run)]
    start, now = (
        sections(curve(run, c), cuts) for c in (run.states[0].coefficients, at_volume(run, ratio))
    )
    return (now - start) / (now - start).sum()


def height(run: PlanarRun, ratio: float) -> float:
    """Of the membrane's middle over its ends at the inlet, when V/V0 is ``ratio``."""
    c, nodes = at_volume(run, ratio), run.structure.shell.basis.nodes
    middle = CubicHermiteSpline(nodes, c[::2], c[1::2])(0.5 * nodes[-1])
    return float(middle[1] - c[0, 1])


def bulge_rows(
    stokes: PlanarRun, uniform: PlanarRun, ratios: Sequence[float], label: str
) -> list[Row]:
    """Height over the inlet and share of the new volume in the middle, at equal volumes."""
    rows = []
    for ratio in ratios:
        heights = [height(run, ratio) for run in (stokes, uniform)]
        middle = [float(shares(run, ratio)[0]) for run in (stokes, uniform)]
        rows.append(
            {
                "case": f"{label}, V/V0 = {ratio:g}",
                "seconds": 0.0,
                "error": heights[0] / heights[1] - 1.0,
                "error_kind": "Stokes over uniform pressure",
                "height": heights[0],
                "height, uniform": heights[1],
                "new volume in the middle": middle[0],
                "in the middle, uniform": middle[1],
            }
        )
    return rows


def fold_rows(stokes: PlanarRun, uniform: PlanarRun, ratios: Sequence[float]) -> list[Row]:
    """Where the new volume of a folded bag goes: chamber, first and last folds."""
    rows = []
    for ratio in ratios:
        a, b = (shares(run, ratio) for run in (stokes, uniform))
        row: Row = {
            "case": f"fold, V/V0 = {ratio:g}",
            "seconds": 0.0,
            "error": float(a[0] - b[0]),
            "error_kind": "difference in the chamber",
        }
        for k, name in enumerate(("chamber", "first folds", "last folds")):
            row[name] = float(a[k])
            row[f"{name}, uniform"] = float(b[k])
        rows.append(row)
    return rows


def rows(quick: bool, pancake: PlanarRun, fold: PlanarRun) -> list[Row]:
    """All comparisons; the two Stokes runs are the benchmark's own."""
    short = pancake.overrides
    wide = simulate("planar-stokes-pancake", *short, UNIFORM)
    found = [
        wide.row("pancake, width 20, uniform pressure", volume_error(wide), error_kind="volume")
    ]
    found += bulge_rows(pancake, wide, (1.01, 1.02, 1.03, 1.04), "width 20")
    if not quick:
        small = [simulate("planar-stokes-pancake", *SMALL, *more) for more in ((), (UNIFORM,))]
        for run, name in zip(small, ("Stokes flow", "uniform pressure"), strict=True):
            case = f"pancake, width 4, {name}"
            found.append(run.row(case, volume_error(run), error_kind="volume"))
        found += bulge_rows(small[0], small[1], (1.1, 1.25, 1.5, 2.0, 2.5), "width 4")
    uniform = simulate("planar-stokes-fold", *fold.overrides, UNIFORM)
    found.append(uniform.row("fold, uniform pressure", volume_error(uniform), error_kind="volume"))
    if not quick:  # short runs have hardly begun to open
        found += fold_rows(fold, uniform, (1.01, 1.05, 1.1))
        empty = simulate("planar-stokes-deflation", UNIFORM)
        case = "deflation, uniform pressure"
        found.append(empty.row(case, volume_error(empty), error_kind="volume"))
    return found
