"""The figures of the top README, one a benchmark, computed from the committed results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .view import filled, markdown, results, rows_of


@dataclass(frozen=True)
class Headline:
    """One line: templates on the last row of a benchmark whose case fits."""

    benchmark: str
    case: str
    what: str
    value: str
    error: str
    only: Mapping[str, Any] = field(default_factory=dict)


HEADLINE = (
    Headline(
        "pancake",
        r"stokes, implicit",
        "a flat bag inflates threefold in Stokes flow: pressure at the end, against statics",
        "{pressure:.5g} in {seconds:.3g} s",
        "{error:.1e}",
    ),
    Headline(
        "shells",
        r"p=3, fused, 1 thread\(s\)",
        "residual and tangent of a cubic shell, beside the same form in plain scikit-fem",
        "{ratio:.3g} times faster",
        "{error:.0e}",
    ),
    Headline(
        "meshes",
        r"plate, degree 3, 878 triangles",
        "bending of a plate on a raw mesh of {triangles} cubic triangles, in H2",
        "rate {rate}",
        "{error:.1e}",
    ),
    Headline(
        "honesty",
        r"flows: quadrature",
        "tractions in thin gaps against the finest rule: {tried} solves",
        "{silent} silently above their tolerance",
        "{error:.1e}",
    ),
    Headline(
        "integrals",
        r"near single",
        "single layer at 1e-4 of an element's size from it (plain Gauss of as many points errs by "
        "{peer_error:.0e})",
        "{points} points",
        "{error:.0e}",
        {"orders": "default"},
    ),
    Headline(
        "compression",
        r"solve, thinness 0.05, h2",
        "flow around a flat bag, {unknowns} unknowns, H2 matrix: traction",
        "{seconds:.3g} s",
        "{error:.1e}",
    ),
    Headline(
        "folds",
        r"accordion \d+, h2",
        "flow around a bag folded {folds} times, {unknowns} unknowns: traction",
        "{seconds:.3g} s",
        "{error:.1e}",
    ),
    Headline(
        "speed",
        r"pancake, all steps",
        "the first line's run, start included, beside the revision before kernels were made faster",
        "{now:.3g} s, {before:.3g} s before",
        "{error:.0e} apart",
    ),
    Headline(
        "pareto",
        r"thin film: mesh, degree 2, 10",
        "two spheres approach each other over a gap of a tenth: force, with default settings",
        "{seconds:.2g} s",
        "{error:.1e}",
    ),
    Headline(
        "planar",
        r"Stokes traction, \d+ segments",
        "planar Stokes traction on a quadrilateral, rate (theory: {expected rate})",
        "{rate:.2f}",
        "{error:.1e}",
    ),
    Headline(
        "coupling",
        r"capsule, .*",
        "steady deformation of a capsule, against theory ({theory:.5f})",
        "{D:.5f} in {seconds:.3g} s",
        "{error:.1e}",
    ),
    Headline(
        "adaptivity",
        r"Re = 10, h = 1/\d+, counting, step 0",
        "modelling error of Stokes flow in a cavity, printed as {printed:.3g} [T fig. 7.3]",
        "{thesis_eps:.4g} in {seconds:.2g} s",
        "{to printed:.0e} off the print",
    ),
)


def headline() -> str:
    """Markdown of the figures, with the machine they were measured on."""
    body = []
    for line in HEADLINE:
        row = rows_of(line.benchmark, line.case, line.only)[-1]
        cells = [filled(text, row) for text in (line.what, line.value, line.error)]
        body.append([*cells, f"`{line.benchmark}`"])
    reports = {line.benchmark: results(line.benchmark) for line in HEADLINE}
    machines = dict.fromkeys(
        "{cores} cores of {processor}".format(**r["machine"]) for r in reports.values()
    )
    loads = [r["machine"]["load"] for r in reports.values()]
    dates = sorted({r["date"] for r in reports.values()})
    quick = [name for name, r in reports.items() if r["quick"]]
    span = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
    which = "" if len(quick) == len(reports) else f" of {', '.join(quick)}"
    small = f", small sizes{which}" if quick else ""
    table = markdown(["what", "measured", "error", "`airfold bench`"], body)
    return (
        f"{table}\nMeasured on {' and '.join(machines)}, {span}{small}; load {min(loads):g} to "
        f"{max(loads):g}: above the number of cores, other jobs ran too and seconds are too long.\n"
    )
