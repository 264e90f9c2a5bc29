"""Rows of folded bags from run folders: crossings are counted, like stands beside like."""

import json

import numpy as np
import pytest

from cases import loader
from cases.benchmarks import record
from cases.benchmarks.folds.like import PREFIX
from cases.benchmarks.folds.opened import crossings, measured
from cases.benchmarks.folds.order import fold_angles, told
from cases.geometry.bag_sampler import BagSampler
from cases.geometry.panels import FoldPanels
from cases.kinds.inflation.plan import InflationPlan
from cases.output.history import History
from cases.output.vtk import write_frames, write_grid
from cases.scene_text import write

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)
NAME = "accordion-2-coarse"


def folder_of(path, angles, overrides=(), crossed=()):
    """A run whose volume doubles in each step."""
    scene = loader.read(NAME, ["output.fields_every=1", *overrides])
    path.mkdir()
    (path / "run.toml").write_text(write(scene))
    session = {"started": "2026-01-02T03:04:05", "seconds": 7.0, "rejections": {"NEWTON": 1}}
    run = {"result": "completed", "sessions": [session, session]}
    (path / "run.json").write_text(json.dumps(run))
    frames, history = [], History(path / "history.csv")
    for k, angle in enumerate(angles):
        points = CORNERS.copy()
        if k in crossed:
            points[7] = [-1.0, 0.4, 0.5]  # through the opposite side
        name = f"fields/frame_{k:06d}.vtu"
        write_grid(
            path / name, {"points": points, "quads": QUADS, "point_data": {}, "cell_data": {}}
        )
        frames.append((float(k), name))
        row = {"step": k, "t": float(k), "volume": 2.0**k, "volume_prescribed": 2.0**k}
        row |= {"pressure": 0.1 * k, "assemblies": 2 * (k > 0)}
        energy = {"membrane_energy": 1.0, "bending_energy": 3.0, "contact_energy": 0.02 * k}
        near = {"contact_distance": np.inf if k == 0 else 1e-3 / k, "panel_angle": angle}
        history.append({**row, **energy, **near})
    write_frames(path / "fields.pvd", frames)
    return path


def test_crossings_are_counted(tmp_path):
    assert crossings(folder_of(tmp_path / "a", [90.0, 80.0, 70.0])) == (3, 0)
    assert crossings(folder_of(tmp_path / "b", [90.0, 80.0, 70.0], crossed=(1,))) == (3, 1)


def test_like_stands_beside_like(tmp_path):
    flow = folder_of(tmp_path / "a", [90.0, 80.0, 70.0])
    other = folder_of(
        tmp_path / "b", [90.0, 70.0, 69.0], ["fluid.model=pressure", "mesh.around=36"]
    )
    assert measured(flow, [flow, other])["beside"] == ""
    like = folder_of(tmp_path / "c", [90.0, 75.0, 69.0], ["fluid.model=pressure", "time.dt=3.0"])
    row = measured(flow, [flow, other, like])
    assert row["angle above"] == pytest.approx(5.0)
    assert row["at V/V0"] == 2.0
    assert row["beside"] == f"{PREFIX}{NAME}, uniform pressure, rigidity 1e-05, time.dt=3.0"
    assert (row["steps"], row["rejected"], row["frames"], row["seconds"]) == (2, 2, 3, 14.0)
    assert row["contact energy share"] == pytest.approx(0.01)
    assert 0.0 < row["distance/reach"] < 1.0


def test_frames_that_were_not_written_show(tmp_path):
    folder = folder_of(tmp_path / "a", [90.0, 80.0, 70.0])
    write_frames(folder / "fields.pvd", [(0.0, "fields/frame_000000.vtu")])
    row = measured(folder)
    assert (row["frames"], row["states"]) == (1, 3)


def test_rows_of_runs_stay_until_taken_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "RESULTS", tmp_path)
    ladder = [{"case": "accordion 2, h2", "seconds": 1.0, "error": 0.1}]
    report = {"benchmark": "folds", "quick": True, "rows": ladder}
    (tmp_path / "new.json").write_text(json.dumps(report))
    record.keep(tmp_path / "new.json", "folds")
    folder = folder_of(tmp_path / "a", [90.0, 80.0])
    record.take([folder], "abc1234")
    record.take([folder], "abc1235")
    record.keep(tmp_path / "new.json", "folds")
    rows = json.loads((tmp_path / "folds.json").read_text())["rows"]
    assert rows[0]["case"] == "accordion 2, h2"
    assert [row["commit"] for row in rows[1:]] == ["abc1235"]
    assert rows[1]["date"] == "2026-01-02"


def test_folds_open_in_turn():
    """Two panels turn back about one fold after the other; half of the angle counts as open."""
    bag = InflationPlan(loader.read(NAME)).bag
    sampler = BagSampler(bag)
    first = np.asarray(sampler.surface_grid(bag.coefficients)["points"])
    last = np.asarray(sampler.surface_grid(bag.flat)["points"])
    quads = np.asarray(sampler.surface_grid(bag.flat)["quads"])
    # the coarse fit leaves 3.6 degrees
    panels = FoldPanels.of(bag)
    assert fold_angles(panels, first, quads) == pytest.approx(180.0, abs=4.0)
    assert fold_angles(panels, last, quads) == pytest.approx(0.0, abs=1.0)
    assert told(np.array([4.0, 2.0, np.nan])) == "2 of 3: 2 at 2.00, 1 at 4.00"
    assert told(np.array([np.nan])) == "0 of 1"
