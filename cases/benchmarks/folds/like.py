"""Like with like: the name of a folded bag's run, and the run that it may be compared with.

A Stokes run is set beside one with uniform pressure only where the scenes agree in geometry, mesh,
structure, inflow and contact, and its angles are compared at equal volumes.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from ...kinds.inflation.config import InflationScene
from ...kinds.inflation.views.equal_volumes import RunByVolume, largest_excess
from ...output.figures import NoPicture
from ...runs.folder import scene_of
from ...scene_text import differences
from ...scenes.gallery import changes
from ...sections import SceneError
from ..report import Row

PREFIX = "opening, "
FREE = ("fluid", "coupling", "time")  # sections in which a run and the one beside it may differ


def named(scene: InflationScene) -> Row:
    """What tells the run of a scene from others."""
    model = "Stokes" if scene.fluid.model == "stokes" else "uniform pressure"
    hidden = ("fluid.model", "structure.flexural_rigidity")
    changed = [c for c in _changes(scene) if not c.startswith(hidden)]
    rigidity = scene.structure.flexural_rigidity
    words = [scene.name, model, f"rigidity {rigidity:g}", *changed]
    return {
        "case": PREFIX + ", ".join(words),
        "scene": scene.name,
        "model": model,
        "rigidity": rigidity,
        "changed": " ".join(changed) or "nothing",
    }


def _changes(scene: InflationScene) -> list[str]:
    with suppress(SceneError):  # no shipped scene of this name
        return list(changes(scene))
    return ["not shipped"]


def beside(folder: Path, scene: InflationScene, others: Sequence[Path]) -> Row:
    """Largest panel angle above that under uniform pressure, at equal volume.

    Parameters
    ----------
    folder : Path
    scene : InflationScene
        Of that folder.
    others : sequence of Path
        Run folders among which one like it is looked for.
    """
    row: Row = {"angle above": np.nan, "at V/V0": np.nan, "beside": ""}
    if scene.fluid.model == "pressure":
        return row
    for other in others:
        peer = scene_of(other)
        if not isinstance(peer, InflationScene) or peer.fluid.model != "pressure":
            continue
        if {key.split(".")[0] for key in differences(scene, peer)} <= set(FREE):
            with suppress(NoPicture):
                above, volume = largest_excess(RunByVolume.of(folder), RunByVolume.of(other))
                return {"angle above": above, "at V/V0": volume, "beside": named(peer)["case"]}
    return row
