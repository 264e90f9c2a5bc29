"""Coupling: contraction, schemes, rates, the capsule, and runs that ask for trouble."""

from __future__ import annotations

from collections.abc import Iterator

from ..report import Row
from . import capsule, rates, stress
from .contraction import contraction_row
from .posed import states
from .schemes import COMMON, MATRIX_FREE, kept_row, scheme_rows

PLANE = "planar-stokes-pancake"
MASSES, STEPS, TIMES = (0.001, 0.005, 0.1, 1.0, 5.0), (0.06, 1.0, 8.0), (0.0, 360.0, 1460.0)


def run(quick: bool) -> Iterator[Row]:
    """Rows of the benchmark; ``quick`` has one planar state and fewer of everything."""
    start = states(PLANE, [], (0.0,))[0]
    scheme_rows(PLANE, [], start, 0.005, 1.0, 1)  # compiles
    for part in (_planar, _round, rates.rows, capsule.rows, stress.rows):
        yield from part(quick)


def _planar(quick: bool) -> Iterator[Row]:
    masses, steps_of = ((0.005, 0.1), (1.0, 8.0)) if quick else (MASSES, STEPS)
    for state in states(PLANE, ["time.dt=4"], TIMES[:1] if quick else TIMES):
        for m in masses:
            for dt in steps_of:
                yield contraction_row(PLANE, [], state, m, dt)
        for m in masses:
            for dt in steps_of:
                yield from scheme_rows(PLANE, [], state, m, dt, 3 if quick else 6)


def _round(quick: bool) -> Iterator[Row]:
    """The round pancakes, at the asked mass ratios and steps, and at ten times and a tenth of m."""
    state = states("pancake", COMMON, (0.0,))[0]
    for m in (0.005,) if quick else (0.005, 0.5):
        for dt in (1.0, 8.0):
            yield contraction_row("pancake", COMMON, state, m, dt)
            yield from scheme_rows("pancake", COMMON, state, m, dt, 3 if quick else 6)
    yield kept_row(1.0, 10 if quick else 40)
    tested = ("implicit", MATRIX_FREE, "auto", "iqn-ils", "aitken")
    for name in () if quick else ("pancake", "pancake-20"):
        for start in states(name, [*COMMON, "time.dt=16"], (0.0, 160.0))[1:]:
            for m in (0.0005, 0.005, 0.05):
                yield from scheme_rows(name, COMMON, start, m, 8.0, 6, tested)
