"""Folded bags that open: what their run folders say, and every frame looked at for crossings.

A row is made of a finished run folder, whoever ran it; `run` makes folders first. A Stokes run is
set beside one with uniform pressure only where the scenes agree in geometry, mesh, structure,
inflow and contact, and its angles are compared at equal volumes.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from scipy.sparse import eye

from coupling.contact.sampled_mesh import SampledMesh

from ... import loader
from ...kinds.inflation.config import InflationScene
from ...kinds.inflation.equal_volumes import RunByVolume, largest_excess
from ...kinds.inflation.plan import InflationPlan
from ...output.figures import NoPicture, frames_of
from ...output.history import read_history
from ...output.vtk import read_grid
from ...runs.folder import scene_of
from ...runs.start import start
from ...scene_text import differences
from ...scenes.gallery import changes
from ...sections import SceneError
from ..report import Row, revision

PREFIX = "opening, "
QUICK = ("accordion-2-coarse", ["structure.reference=creased", "time.dt=10.0"])
PRESSURE = "fluid.model=pressure"
FREE = ("fluid", "coupling", "time")  # sections in which a run and the one beside it may differ
WORKING = 0.01  # of the largest stored energy: below it shares of it mean nothing


def run(quick: bool) -> Iterator[Row]:
    """Run every shipped folded bag in Stokes flow and under uniform pressure, and measure it.

    ``quick``: a coarse accordion under uniform pressure alone.
    """
    names = [name for name in loader.shipped() if _folded(loader.read(name))]
    runs = [(name, [o]) for name in names for o in (PRESSURE, "fluid.model=stokes")]
    if quick:
        name, overrides = QUICK
        runs = [(name, [*overrides, PRESSURE])]
    with tempfile.TemporaryDirectory() as place:
        folders = []
        for k, (name, overrides) in enumerate(runs):
            folders.append(Path(place) / str(k))
            failed = _run(name, [*overrides, "output.fields_every=1"], folders[-1])
            if failed:
                yield failed
                folders.pop()
                continue
            # the run under uniform pressure comes first
            yield measured(folders[-1], folders[:-1])


def _folded(scene: object) -> bool:
    return isinstance(scene, InflationScene) and InflationPlan(scene).folded


def _run(name: str, overrides: Sequence[str], folder: Path) -> Row | None:
    """Run a scene; a row of its failure where it cannot be built."""
    from rich.console import Console

    scene = loader.read(name, [*overrides, "output.picture=false"])
    assert isinstance(scene, InflationScene)  # folded bags are
    try:
        start(scene, folder, Console(quiet=True))
    except SceneError as error:
        return {**_named(scene), "seconds": 0.0, "error": np.nan, "reference": f"none: {error}"}
    return None


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
        A folder whose run is no inflation, or was not recorded frame by frame.
    """
    scene = scene_of(folder)
    if not isinstance(scene, InflationScene):
        raise ValueError(f"{folder}: {scene.kind} is no inflation of a folded bag")
    history, (record, _) = read_history(folder / "history.csv"), _record(folder)
    frames, crossing = crossings(folder)
    steps = int(history["step"][-1])
    # the start and every step, each of which may cross
    if frames < steps + 1:
        raise ValueError(
            f"{folder} has {frames} frames of {steps} steps: run with output.fields_every=1"
        )
    sessions = record["sessions"]
    rejected = sum(sum(s.get("rejections", {}).values()) for s in sessions)
    volume = history["volume"] / history["volume"][0]
    row: Row = {
        **_named(scene),
        "seconds": float(sum(s.get("seconds", 0.0) for s in sessions)),
        "error": float(np.abs(history["volume"] / history["volume_prescribed"] - 1.0).max()),
        "error_kind": "volume",
        "V/V0": float(volume.max()),
        "V/V0 asked": scene.inflow.final_volume,
        "result": str(record["result"]).upper(),
        "steps": steps,
        "rejected": rejected,
        "rejected share": rejected / max(steps + rejected, 1),
        "frames": frames,
        "crossing": crossing,
        "largest angle": float(history["panel_angle"][-1]) if "panel_angle" in history else np.nan,
        **_contact(scene, history),
    }
    return {**row, **_beside(folder, scene, others)}


def crossings(folder: Path) -> tuple[int, int]:
    """Number of a run's frames, and of those in which triangles cross each other."""
    mesh, found, frames = None, 0, frames_of(folder)
    for _, name in frames:
        grid = read_grid(folder / name)
        if mesh is None:
            quads = grid.cells_dict["quad"]
            mesh = SampledMesh.of(eye(len(grid.points), format="csr"), quads, grid.points)
        found += mesh.intersects(grid.points)
    return len(frames), found


def _named(scene: InflationScene) -> Row:
    """What tells the run of a scene from others."""
    model = "Stokes" if scene.fluid.model == "stokes" else "uniform pressure"
    hidden = ("output.", "fluid.model", "structure.flexural_rigidity")
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


def _beside(folder: Path, scene: InflationScene, others: Sequence[Path]) -> Row:
    """Largest panel angle above that under uniform pressure, at equal volume."""
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
                return {"angle above": above, "at V/V0": volume, "beside": _named(peer)["case"]}
    return row


def _record(folder: Path) -> tuple[dict, str]:
    """run.json of a folder, and the date of its last session."""
    record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return record, record["sessions"][-1]["started"][:10]
