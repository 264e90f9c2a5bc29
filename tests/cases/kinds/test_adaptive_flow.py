"""Model-adaptive scenes through the console: validation, run folder, resume, picture, forecast."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cases import cli, loader
from cases.kinds.adaptive_flow import run as flow_run
from cases.kinds.adaptive_flow.forecast import forecast
from cases.output.history import read_history
from cases.output.vtk import read_frames
from cases.scene_text import write

RUN = ["run", "cavity-re10", "--set", "flow.cells=10", "--set", "adaptivity.tolerance=1e-4"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flow") / "run"
    assert cli.main([*RUN, "--out", str(folder)]) == 0
    return folder


@pytest.mark.parametrize("name", ["cavity-re10", "cavity-re100", "cavity-re1000"])
def test_scenes_are_valid_and_round_trip(name, tmp_path):
    scene = loader.read(name)
    (tmp_path / "again.toml").write_text(write(scene))
    assert loader.read(tmp_path / "again.toml") == scene
    assert not forecast(scene).warnings


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("goal.region=[1.9,2.1,-1.0,-0.9]", "lies outside the domain"),
        ("goal.region=[1.93,2.0,-1.0,-0.9]", "cuts elements of size 1/80"),
        ("goal.region=[2.0,1.9,-1.0,-0.9]", "is empty"),
        ("flow.reynolds=5000", "out of the laminar range"),
        ("flow.refinements=2", "'exact' shares do not exist on triangles"),
        ("kind='steady'", "is none of 'inflation', 'capsule', 'model-adaptivity'"),
        ("mesh.degree=2", "unknown key"),
        ("adaptivity.indicator='count'", "is none of"),
    ],
)
def test_bad_input_is_named_before_work(change, message):
    more = ["adaptivity.indicator=exact"] if "refinements" in change else []
    with pytest.raises(loader.SceneError) as caught:
        loader.read("cavity-re10", [change, *more])
    assert any(message in error for error in caught.value.errors)


def test_a_velocity_goal_stays_inside():
    overrides = ["goal.kind=velocity", "goal.point=[0.5,0.05]"]
    with pytest.raises(loader.SceneError, match=r"goal\.point"):
        loader.read("cavity-re10", overrides)


def test_run_folder(finished, capsys):
    names = {path.name for path in finished.iterdir()}
    assert names == {
        "run.toml", "run.json", "history.csv", "fields.pvd", "fields", "checkpoint.npz",
        "overview.png", "run.lock",
    }  # fmt: skip
    history = read_history(finished / "history.csv")
    assert history["bound"][-1] < 1e-4
    assert history["thesis_eps"] == pytest.approx(-history["estimate"])
    record = json.loads((finished / "run.json").read_text())
    assert record["result"] == "completed"
    assert any(s.startswith("discretisation error") for s in record["skips"])
    frames = read_frames(finished / "fields.pvd")
    assert len(frames) == len(history["step"])
    assert (finished / "overview.png").stat().st_size > 10_000
    (finished / "overview.png").unlink()
    assert cli.main(["report", str(finished)]) == 0


def test_a_stopped_run_resumes_with_the_same_rows(tmp_path, finished, monkeypatch):
    folder = tmp_path / "run"
    real, seen = flow_run._line, []

    def interrupting(step):
        seen.append(step.index)
        if step.index == 2:
            raise KeyboardInterrupt
        return real(step)

    monkeypatch.setattr(flow_run, "_line", interrupting)
    assert cli.main([*RUN, "--out", str(folder)]) == 130
    assert json.loads((folder / "run.json").read_text())["result"] == "interrupted"
    monkeypatch.setattr(flow_run, "_line", real)
    assert cli.main(["resume", str(folder)]) == 0
    a, b = (read_history(f / "history.csv") for f in (folder, finished))
    for name in a.keys() - {"wall_time"}:
        assert np.array_equal(a[name], b[name], equal_nan=True), name
    assert len(read_frames(folder / "fields.pvd")) == len(a["step"])


def test_resume_refuses_another_scene(tmp_path, finished, capsys):
    text = (finished / "run.toml").read_text()
    (finished / "run.toml").write_text(text.replace("parameter = 0.1", "parameter = 0.2"))
    assert cli.main(["resume", str(finished)]) == 2
    assert "belongs to another scene" in capsys.readouterr().err
    (finished / "run.toml").write_text(text)


def test_the_step_limit_is_told(tmp_path, capsys):
    folder = tmp_path / "run"
    assert cli.main([*RUN, "--set", "adaptivity.max_steps=1", "--out", str(folder)]) == 1
    assert "STEP_LIMIT at step 1" in capsys.readouterr().err


@pytest.mark.parametrize("goal", ["traction", "kinetic-energy", "velocity"])
def test_other_goals_on_adapted_triangles(tmp_path, goal):
    overrides = [f"goal.kind={goal}", "flow.refinements=1", "adaptivity.indicator=integral"]
    arguments = [f"--set={o}" for o in [*overrides, "output.fields_every=0"]]
    folder = tmp_path / "run"
    assert (
        cli.main([*RUN[:4], *arguments, "--set=adaptivity.tolerance=1e-2", "--out", str(folder)])
        == 0
    )
    history = read_history(folder / "history.csv")
    assert history["bound"][-1] < 1e-2
    assert abs(history["error_rel_J0"][-1]) < 1e-2
