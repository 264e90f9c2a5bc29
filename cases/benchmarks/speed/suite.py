"""Speeds now and before, in turns, and whether results are the same.

A row has ``seconds`` now, ``before``, their ``ratio``, the ratio (or value) ``asked``, and as
``error`` the largest relative difference of results; what is no time has its ``unit``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..integrals.suite import pairs
from ..report import Row
from .coupled import STATE
from .earlier import REVISION, ROOT, Figures, figures, tree
from .start import seconds_to_first_step

__all__ = ["pairs", "run"]
FIRST = ("pancake", "time.end=16", "output.picture=false")  # a scene's start: one step
LARGE, LARGEST = 258, 424  # elements around of 1e5 and 2.7e5 unknowns


@dataclass(frozen=True)
class Timed:
    """What a probe finds under a name, shown as a row."""

    figure: str
    what: str
    unit: str = "s"
    asked: float = np.nan
    same: tuple[str, ...] = ()
    limit: str = ""


@dataclass(frozen=True)
class Probe:
    """A function of a script, run under both trees in turns; the least of each figure counts."""

    script: str
    function: str
    arguments: tuple[Any, ...]
    items: tuple[Timed, ...]
    threads: int = 0
    turns: int = 2
    before: bool = True

    def rows(self) -> Iterator[Row]:
        """Its items, now and before."""
        earlier = tree() if self.before else None
        trees = [ROOT] if earlier is None else [earlier, ROOT]
        found: dict[Any, list[Figures]] = {root: [] for root in trees}
        for _ in range(self.turns):
            for root in trees:
                call = self.script, root, self.function, *self.arguments
                found[root].append(figures(*call, threads=self.threads))
        for item in self.items:
            now, old = found[ROOT], found.get(earlier, []) if earlier else []
            yield row(item, now, old)


def row(item: Timed, now: Sequence[Figures], before: Sequence[Figures]) -> Row:
    """One item of both."""
    least = [min(f[item.figure] for f in runs) for runs in (now, before) if runs]
    pairs_of = [(now[0][name], before[0][name]) for name in item.same] if before else []
    off = [abs(a - b) / max(abs(b), 1e-300) for a, b in pairs_of if a != b]
    compared = {"before": least[1], "ratio": least[0] / least[1]} if before else {}
    return {
        "case": item.what,
        "seconds": least[0] if item.unit == "s" else 0.0,
        "now": least[0],
        **compared,
        "asked": item.asked,
        "of limit": now[0][item.limit] / least[0] if item.limit else np.nan,
        "unit": item.unit,
        "error": max(off, default=0.0 if pairs_of else np.nan),
        "reference": "results before" if pairs_of else "none: a time alone",
        "peer": f"revision {REVISION}" if before else "none",
    }


def probes(quick: bool) -> Iterator[Probe]:
    """What is measured, in this order; small sizes with ``quick``."""
    for scene, steps, asked in (("accordion", 33, 0.54), ("pancake", 50, 0.44)):
        yield Probe(
            "coupled",
            "figures",
            (scene, 4 if quick else steps),
            (
                Timed("wall", f"{scene}, all steps", asked=asked, same=STATE[:-1]),
                Timed("assemblies", f"{scene}, assemblies", "count"),
                Timed("newton_iterations", f"{scene}, Newton iterations", "count"),
            ),
            turns=1,
        )
    yield Probe(
        "structure",
        "figures",
        (quick,),
        tuple(
            Timed(f"{shell}, {work}, assembled", f"shell, {work}: {shell}", "us/element", asked)
            for shell in ("pancake", "accordion-2", "triangles, degree 3")
            for work, asked in (("residual", 0.54), ("tangent", 0.69))
        ),
        threads=1,
    )
    around = 32 if quick else 102
    for gap in (0.05, 0.01):
        name = f"near field, {around**2 // 2} elements, thinness {gap:g}"
        yield Probe(
            "near",
            "near_costs",
            (around, gap, 1),
            (
                Timed("seconds", name, asked=0.38, same=("pairs", "points")),
                Timed("ns a point", f"{name}: a point", "ns", 0.38),
                Timed("us a pair", f"{name}: a pair", "us", 0.5),
                Timed("two threads", f"{name}: two threads", "times", np.nan),
            ),
            turns=1,
        )
    sizes = ("pancake's size", "1000 elements")
    large = f"{44**2 // 2 if quick else 102**2 // 2} elements"
    parts = ("patch blocks", "coarse image", "preconditioner")
    yield Probe(
        "dense",
        "figures",
        (quick,),
        (
            Timed("limit, s/pair", "limit: point sums", "s/pair"),
            *(Timed(f"{n}, dense matrix", f"dense layer, {n}") for n in sizes),
            *(
                Timed(f"{n}, s/pair", f"dense layer, {n}: a pair", "s/pair", limit="limit, s/pair")
                for n in sizes
            ),
            *(Timed(f"{large}, {p}", f"{p}, {large}") for p in parts),
        ),
        threads=1,
        turns=1,
    )
    points = 10_000 if quick else 100_000
    for cloud, asked in (("sphere", 0.59), ("stack", np.nan)):
        name = f"H2, {points} points, {cloud}"
        yield Probe(
            "far",
            "cloud",
            (cloud, points, 1e-3),
            (
                Timed("seconds", f"{name}: product", asked=asked),
                Timed("build", f"{name}: build"),
                Timed("error", f"{name}: error of the product", "relative"),
            ),
            threads=1,
            turns=1,
        )
        yield Probe(
            "far",
            "peer",
            (cloud, points, 1e-3),
            (Timed("seconds", f"FMM3D, {points} points, {cloud}: product"),),
            threads=1,
            turns=1,
            before=False,
        )
    sizes_around = [around] if quick else [around, LARGE, LARGEST]
    for n in sizes_around:
        yield _solve(n, n < LARGE)


def _solve(around: int, before: bool) -> Probe:
    name = f"solve, {around**2 // 2} elements"
    asked = {102: 0.53}.get(around, np.nan)
    parts = ("near", "build", "preconditioner", "gmres", "product")
    return Probe(
        "far",
        "solve",
        (around, 0.05),
        (
            Timed("seconds", name, asked=asked),
            *(Timed(part, f"{name}: {part}") for part in parts),
            Timed("iterations", f"{name}: iterations", "count"),
            Timed("peak GB", f"{name}: peak", "GB"),
        ),
        turns=1,
        before=before,
    )


def start_rows() -> Iterator[Row]:
    """Seconds until the first step and the first news of a run, without and with kernels."""
    earlier = tree()
    trees = [ROOT] if earlier is None else [earlier, ROOT]
    for cold, word in ((True, "first start"), (False, "warm start")):
        found = {root: [seconds_to_first_step(*FIRST, cold=cold, root=root)] for root in trees}
        for figure, asked in (("first step", 0.375 if cold else 0.3), ("news", np.nan)):
            item = Timed(figure, f"{word}: {figure}", asked=asked)
            yield row(item, found[ROOT], found[earlier] if earlier else [])


def run(quick: bool) -> Iterator[Row]:
    """All rows, as they come."""
    yield from start_rows()
    for probe in probes(quick):
        yield from probe.rows()
