"""Rates of the coupled problem on a smooth inflation: in time, and in space in the H2 norm.

A planar circle is blown up through its inlet, Stokes flow inside and outside. The coupling
tolerance is far below the errors, which are those of the end configuration over the displacement
since the start.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ... import loader
from ...kinds import simulation
from ...kinds.planar import build
from ...kinds.planar.config import PlanarScene
from ..recorded import RecordedHistory
from ..report import Row

SMOOTH = (
    "geometry.asymmetry=0.0", "mesh.inlet=4", "inflow.final_volume=1.2", "inflow.t1=60",
    "inflow.t2=60", "structure.flexural_rigidity=1e-2", "coupling.tolerance=1e-9",
    "fluid.mass_ratio=0.05", "coupling.absolute_tolerance=1e-12",
    "coupling.max_iterations=20", "time.closing=0",
)  # fmt: skip
END = 60.0  # the influx has just reached its peak


class Curve:
    """End displacement of a run, as a Hermite curve over arc length."""

    def __init__(self, elements: int, steps: int, integrator: str):
        scene = loader.read(
            "planar-stokes-deflation",
            [
                *SMOOTH,
                f"mesh.uniform={elements}",
                f"time.dt={END / steps}",
                f"time.end={END}",
                f"time.integrator={integrator}",
            ],
        )
        assert isinstance(scene, PlanarScene)
        history = RecordedHistory()
        began = time.process_time()
        outcome = simulation(scene, [history]).run()
        self.seconds = time.process_time() - began
        if not outcome.result.ok or outcome.counts["rejected"]:
            raise ArithmeticError(f"{outcome.result.name}, {outcome.summary}")
        moved = history.states[-1].coefficients - history.states[0].coefficients
        self.nodes = build.bag(scene).nodes
        self.spline = CubicHermiteSpline(self.nodes, moved[::2], moved[1::2])

    def distance(self, other: Curve, order: int, margin: float = 0.0) -> float:
        """Relative Sobolev distance of the displacements, derivatives up to ``order``.

        ``margin`` is the length left out at both ends, where the traction is singular.
        """
        n = 8 * max(self.nodes.size, other.nodes.size)
        s = np.linspace(margin, self.nodes[-1] - margin, n + 1)
        s = 0.5 * (s[1:] + s[:-1])
        scale = s * other.nodes[-1] / self.nodes[-1]  # lengths of coarse polygons may differ
        error = sum(np.sum((self.spline(s, k) - other.spline(scale, k)) ** 2)
                    for k in range(order + 1))  # fmt: skip
        size = sum(np.sum(other.spline(scale, k) ** 2) for k in range(order + 1))
        return float(np.sqrt(error / size))


def _rows(
    kind: str,
    runs: dict[int, Curve],
    reference: Curve,
    what: str,
    order: int = 0,
    margin: float = 0.0,
) -> list[Row]:
    found, last = [], None
    for n, run in runs.items():
        error = run.distance(reference, order, margin)
        rate = float("nan") if last is None else np.log(last[1] / error) / np.log(n / last[0])
        found.append(
            {
                "case": f"{kind}: {n} {what}",
                "seconds": run.seconds,
                "error": error,
                "reference": "finer run",
                "norm": (f"H{order}" if order else "L2")
                + (f", {margin:g} from the ends left out" if margin else ""),
                "rate": rate,
            }
        )
        last = n, error
    return found


def rows(quick: bool) -> list[Row]:
    """Temporal errors of both integrators on one mesh, spatial ones at one time step."""
    steps, fine = ((10, 20, 40), 160) if quick else ((20, 40, 80, 160), 640)
    reference = Curve(32, fine, "bdf2")
    found = []
    for integrator in ("backward-euler", "bdf2"):
        runs = {n: Curve(32, n, integrator) for n in steps}
        found += _rows(integrator, runs, reference, "steps")
    meshes, finest = ((16, 32), 128) if quick else ((24, 48, 96), 192)
    runs = {n: Curve(n, 10, "bdf2") for n in meshes}
    finest_run = Curve(finest, 10, "bdf2")
    for order, margin in ((2, 0.0), (2, 3.0), (0, 0.0)):
        found += _rows("space", runs, finest_run, "elements", order, margin)
    return found
