"""The coupled pancake and the roof: errors of a run's end and of a deflection, over seconds."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import cache

import numpy as np

from ..pancake.suite import FAST, profile, simulate
from ..report import Row
from ..shells.roof import CONVERGED, roof

COARSE = ("mesh.around=8", "mesh.rim=3", "mesh.flat_max=4.0", "mesh.pole=3.0")
FINE = ("mesh.around=16", "mesh.rim=6", "mesh.fillet=3", "mesh.flat_max=2.0", "mesh.disc=3")
SETTINGS: dict[str, dict[str, tuple[str, ...]]] = {
    "mesh, degree 3": {"coarse": COARSE, "default": (), "fine": FINE},
    "mesh, degree 2": {
        name: ("mesh.degree=2", *mesh)
        for name, mesh in (("coarse", COARSE), ("default", ()), ("fine", FINE))
    },
    "time step": {f"{dt:g}": (f"time.dt={dt:g}",) for dt in (4.0, 8.0, 16.0, 32.0)},
    "tolerance": {f"{t:g}": (f"fluid.tolerance={t:g}",) for t in (1e-1, 1e-2, 1e-3, 1e-4)},
    "rule": {f"outer {n}": (f"fluid.outer_points={n}",) for n in (2, 3, 4)},
}
CONVERGING = (*FINE, "time.dt=4.0", "fluid.tolerance=1e-4")


@cache
def _end(overrides: tuple[str, ...], end: float) -> tuple[np.ndarray, float]:
    """Pressure, height and radius at the end of the first part of the pancake, and seconds."""
    start = time.perf_counter()
    run = simulate("pancake", [*overrides, f"time.end={end:g}"])
    seconds = time.perf_counter() - start
    return np.array([run.end.pressure, *profile(run.body, run.end.coefficients)]), seconds


def pancake_rows(quick: bool) -> Iterator[Row]:
    """The jet's rise: the largest error of pressure, height and radius at t = 160."""
    common, end = (FAST, 64.0) if quick else ((), 160.0)
    chosen = {"time step", "rule"} if quick else set(SETTINGS)
    converging = (*common, "time.dt=8.0", "fluid.outer_points=3") if quick else CONVERGING
    converged, _ = _end(converging, end)
    for family, settings in SETTINGS.items():
        for setting, overrides in settings.items() if family in chosen else ():
            found, seconds = _end((*common, *overrides), end)
            yield row(
                "pancake",
                family,
                setting,
                seconds,
                float(np.abs(found / converged - 1.0).max()),
                f"a run with {' '.join(converging)}",
                (family, setting) == ("mesh, degree 3", "default"),
            )


def roof_rows(quick: bool) -> Iterator[Row]:
    """Deflection of the Scordelis-Lo roof."""
    for degree in (2, 3, 4):
        for n in (4, 8, 16) if quick else (4, 8, 16, 32, 64):
            for membrane in ("gauss", "reduced"):
                deflection, seconds = roof(n, degree, membrane=membrane)
                yield row(
                    "roof",
                    f"degree {degree}, {membrane}",
                    f"{n}",
                    seconds,
                    abs(deflection / CONVERGED - 1.0),
                    "degrees 4 and 5 on finer meshes",
                    (degree, n, membrane) == (3, 16, "gauss"),
                )


def row(
    problem: str,
    family: str,
    setting: str,
    seconds: float,
    error: float,
    reference: str,
    default: bool,
) -> Row:
    """One point of a picture."""
    return {
        "case": f"{problem}: {family}, {setting}",
        "seconds": seconds,
        "error": error,
        "reference": reference,
        "problem": problem,
        "family": family,
        "setting": setting,
        "default": default,
    }
