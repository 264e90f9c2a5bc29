"""What the run folder of a folded bag says, and every frame of it looked at for crossings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.sparse import eye

from coupling.contact.sampled_mesh import SampledMesh

from ...geometry.panels import FoldPanels
from ...kinds.inflation.config import InflationScene
from ...kinds.inflation.plan import InflationPlan
from ...kinds.inflation.views.equal_volumes import RunByVolume
from ...output.figures import NoPicture, frames_of
from ...output.history import read_history
from ...output.vtk import flat_cells_of, read_grid
from ...runs.folder import scene_of
from ..report import Row, revision
from .like import beside, named
from .order import opened_at, told

WORKING = 0.01  # of the largest stored energy: below it shares of it mean nothing


def rows_of_runs(folders: Sequence[Path], commit: str = "") -> list[Row]:
    """Rows of finished run folders, each with its date and the commit that it is said to be of."""
    return [
        {**measured(folder, folders), "commit": commit or revision(), "date": _record(folder)[1]}
        for folder in folders
    ]


def measured(folder: Path, others: Sequence[Path] = ()) -> Row:
    """What a finished run of a folded bag comes to.

    Parameters
    ----------
    folder : Path
    others : sequence of Path
        Run folders among which a run under uniform pressure is looked for, to stand beside.

    Raises
    ------
    ValueError
        A folder whose run is no inflation.
    """
    scene = scene_of(folder)
    if not isinstance(scene, InflationScene):
        raise ValueError(f"{folder}: {scene.kind} is no inflation of a folded bag")
    history, (record, _) = read_history(folder / "history.csv"), _record(folder)
    frames, crossing = crossings(folder)
    steps = int(history["step"][-1])
    sessions = record["sessions"]
    rejected = sum(sum(s.get("rejections", {}).values()) for s in sessions)
    volume = history["volume"] / history["volume"][0]
    row: Row = {
        **named(scene),
        "seconds": float(sum(s.get("seconds", 0.0) for s in sessions)),
        "error": float(np.abs(history["volume"] / history["volume_prescribed"] - 1.0).max()),
        "error_kind": "volume",
        "V/V0": float(volume.max()),
        "V/V0 asked": scene.inflow.final_volume,
        "result": str(record["result"]).upper(),
        "steps": steps,
        "rejected": rejected,
        "rejected share": rejected / max(steps + rejected, 1),
        "states": steps + 1,
        "frames": frames,
        "crossing": crossing,
        "largest pressure": float(history["pressure"].max()),
        "assemblies a step": float(history["assemblies"].sum()) / max(steps, 1),
        "folds open": _order(folder, scene),
        "largest angle": float(history["panel_angle"][-1]) if "panel_angle" in history else np.nan,
        **_contact(scene, history),
    }
    return {**row, **beside(folder, scene, others)}


def _order(folder: Path, scene: InflationScene) -> str:
    panels = FoldPanels.of(InflationPlan(scene).bag)
    if panels is None or not panels.folding.squared_curvature:
        return "no folds"
    try:
        volumes = opened_at(panels, RunByVolume.of(folder))
    except NoPicture:
        return "too few frames"
    return told(volumes) if len(volumes) else "frames of another mesh"


def crossings(folder: Path) -> tuple[int, int]:
    """Number of a run's frames, and of those in which triangles cross each other."""
    mesh, found, frames = None, 0, frames_of(folder)
    for _, name in frames:
        grid = read_grid(folder / name)
        if mesh is None:
            quads = flat_cells_of(grid).corners
            mesh = SampledMesh.of(eye(len(grid.points), format="csr"), quads, grid.points)
        found += mesh.intersects(grid.points)
    return len(frames), found


def _contact(scene: InflationScene, history: dict[str, np.ndarray]) -> Row:
    """Nearest distance over the reach, and the potential's energy over the stored one."""
    if "contact_distance" not in history:
        return {"distance/reach": np.nan, "contact energy share": np.nan}
    carried = InflationPlan(scene).carried
    assert carried is not None  # it wrote these columns
    near = float(history["contact_distance"].min()) / carried.reach
    stored = history["membrane_energy"] + history["bending_energy"]
    works = stored > WORKING * stored.max()
    share = history["contact_energy"][works] / stored[works]
    return {
        "distance/reach": near if np.isfinite(near) else np.nan,
        "contact energy share": float(share.max(initial=0.0)),
    }


def _record(folder: Path) -> tuple[dict, str]:
    """run.json of a folder, and the date of its last session."""
    record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return record, record["sessions"][-1]["started"][:10]
