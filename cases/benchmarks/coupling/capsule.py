"""Capsule in planar strain: steady Taylor deformation against small-deformation theory."""

from __future__ import annotations

import time

from ... import loader
from ...kinds import simulation
from ...kinds.capsule.config import CapsuleScene
from ..recorded import RecordedHistory
from ..report import Row

RATIOS = (0.3, 1.0, 3.0)


def capsule_row(ratio: float, poisson: float, rows: int, around: int) -> Row:
    """Steady D at Ca = 0.005, by steps of four relaxation times."""
    step = 40.0 * (1.0 + ratio)
    scene = loader.read(
        "capsule",
        [
            f"fluid.viscosity_ratio={ratio}",
            f"structure.poisson_ratio={poisson}",
            f"mesh.rows={rows}",
            f"mesh.around={around}",
            f"time.dt={step}",
            f"time.end={5 * step}",
        ],
    )
    assert isinstance(scene, CapsuleScene)
    history = RecordedHistory()
    began = time.process_time()
    outcome = simulation(scene, [history]).run()
    last = [row["deformation"] for row in history.rows[-2:]]
    return {
        "case": f"capsule, lambda = {ratio:g}, nu = {poisson:g}, {rows} x {around}",
        "seconds": time.process_time() - began,
        "error": abs(history.rows[-1]["to_theory"]),
        "reference": "small-deformation theory",
        "capillary": scene.flow.capillary,
        "flexural": scene.structure.flexural_rigidity,
        "D": last[-1],
        "theory": scene.exact_deformation,
        "change in the last step": abs(last[-1] / last[0] - 1.0),
        "assemblies/step": outcome.counts["assemblies"] / outcome.step,
        "rejected": outcome.counts["rejected"],
    }


def rows(quick: bool) -> list[Row]:
    """Three viscosity ratios, two Poisson ratios, three meshes."""
    if quick:
        return [capsule_row(1.0, 0.0, 8, 12)]
    found = [capsule_row(ratio, nu, 8, 12) for nu in (0.0, 0.3) for ratio in RATIOS]
    return found + [capsule_row(1.0, 0.0, n, m) for n, m in ((6, 8), (12, 16))]
