"""Shell scenes through the console: validation, run folder, resume, forecast, failure."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

from cases import cli, loader
from cases.kinds.load_path import build
from cases.kinds.load_path import run as shell_run
from cases.kinds.load_path.forecast import forecast
from cases.kinds.load_path.published import ANNULUS_TABLE, SHEAR_TABLE, exact_moment, reference
from cases.output.history import read_history
from cases.output.vtk import read_frames
from cases.scene_text import write

SCENES = ["cantilever-shear", "cantilever-moment", "slit-annulus"]
RUN = ["run", "cantilever-shear", "--set", "mesh.along=8", "--set", "load.steps=10"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shell") / "run"
    assert cli.main([*RUN, "--out", str(folder)]) == 0
    return folder


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_valid_round_trip_and_have_a_reference(name, tmp_path):
    scene = loader.read(name)
    (tmp_path / "again.toml").write_text(write(scene))
    assert loader.read(tmp_path / "again.toml") == scene
    assert not forecast(scene).warnings
    assert reference(scene) is not None
    other = loader.read(name, ["structure.poisson_ratio=0.3"])
    assert reference(other) is None


def test_shipped_steps_meet_every_published_fraction():
    for name, table in (("cantilever-shear", SHEAR_TABLE), ("slit-annulus", ANNULUS_TABLE)):
        scene = loader.read(name)
        n = scene.load.steps
        met = [k for k in range(1, n + 1) if reference(scene).at(k / n) is not None]
        assert len(met) == len(table)


def test_exact_moment_has_a_largest_load():
    scene = loader.read("cantilever-moment")
    moment = (scene.geometry, scene.structure, scene.load)
    # the inextensible strip closes to a circle; the elastic one ends 5.4e-3 short of it
    assert exact_moment(*moment, 1.0) == pytest.approx([12.0, 0.0], abs=0.01)
    assert exact_moment(*moment, 100.0) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("load.force=[0.0,0.0,0.0]", "load.force: is zero and moves nothing"),
        ('load={kind="moment", moment=0.0}', "load.moment: is zero and moves nothing"),
        ("load.force=[1.0,2.0]", "load.force: must be a list of 3 numbers"),
        ("geometry.outer=5.0", "geometry.outer: 5 must exceed geometry.inner = 6"),
        ("structure.thickness=7.0", "makes this no shell"),
        ("mesh.degree=5", "mesh.degree: 5 is none of 2, 3, 4"),
        ("fluid.model=stokes", "fluid: unknown key"),
        ("inflow.t1=3.0", "inflow: unknown key"),
        ("load.stepz=3", "did you mean 'steps'?"),
    ],
)
def test_bad_input_is_named_before_work(change, message):
    with pytest.raises(loader.SceneError) as caught:
        loader.read("slit-annulus", [change])
    assert any(message in error for error in caught.value.errors)


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("cantilever-moment", ["mesh.degree=2", "mesh.along=8"], "membrane locking"),
        ("cantilever-moment", ["load.moment=500.0"], "thin-shell theory ends"),
        ("slit-annulus", ["load.steps=3"], "meets no published load fraction"),
    ],
)
def test_forecast_warns(name, changes, message):
    assert any(message in w for w in forecast(loader.read(name, changes)).warnings)


def test_run_folder(finished):
    names = {path.name for path in finished.iterdir()}
    assert names == {
        "run.toml", "run.json", "history.csv", "fields.pvd", "fields", "checkpoint.npz",
        "overview.png", "run.lock",
    }  # fmt: skip
    history = read_history(finished / "history.csv")
    assert history["load"] == pytest.approx(np.arange(11) / 10)
    # the deviation is that of the displacements beside it; eight elements of degree 3 reach 2e-3
    tips = np.stack([-history["tip_x"], history["tip_z"]], axis=1)[1:]
    table = SHEAR_TABLE[1:]
    off = np.abs(tips - table[:, 1:]).max(axis=1) / table[-1, 1:].max()
    assert history["deviation"][1:] == pytest.approx(off)
    assert off.max() < 2e-3
    assert np.abs(history["tip_y"]).max() < 1e-8
    # the work of the dead load (trapezoidal rule) is what the shell stores
    stored = history["membrane_energy"] + history["bending_energy"]
    work = np.trapezoid(4.0 * history["load"], history["tip_z"])
    assert stored[-1] == pytest.approx(work, rel=0.01)
    record = json.loads((finished / "run.json").read_text())
    assert record["result"] == "completed"
    newton = record["sessions"][0]["counts"]["newton_iterations"]
    assert newton == history["newton_iterations"].sum()
    assert len(read_frames(finished / "fields.pvd")) == 11
    (finished / "overview.png").unlink()
    assert cli.main(["report", str(finished)]) == 0
    assert (finished / "overview.png").stat().st_size > 10_000


def test_a_stopped_run_resumes_with_the_same_rows(tmp_path, finished, monkeypatch):
    folder = tmp_path / "run"
    real = shell_run._Steps._frame

    def interrupting(self, c, fraction):
        real(self, c, fraction)
        if self.step == 4:  # row and frame are written, the checkpoint is not
            raise KeyboardInterrupt

    monkeypatch.setattr(shell_run._Steps, "_frame", interrupting)
    assert cli.main([*RUN, "--out", str(folder)]) == 130
    assert json.loads((folder / "run.json").read_text())["result"] == "interrupted"
    monkeypatch.setattr(shell_run._Steps, "_frame", real)
    assert cli.main(["resume", str(folder)]) == 0
    a, b = (read_history(f / "history.csv") for f in (folder, finished))
    for name in a.keys() - {"wall_time"}:
        assert np.array_equal(a[name], b[name], equal_nan=True), name
    assert len(read_frames(folder / "fields.pvd")) == len(a["step"])
    # a finished run has nothing left to do
    assert cli.main(["resume", str(folder)]) == 0
    assert len(read_history(folder / "history.csv")["step"]) == 11


def test_resume_refuses_another_scene(tmp_path, finished, capsys):
    text = (finished / "run.toml").read_text()
    (finished / "run.toml").write_text(text.replace("along = 8", "along = 9"))
    assert cli.main(["resume", str(finished)]) == 2
    assert "belongs to another scene" in capsys.readouterr().err
    (finished / "run.toml").write_text(text)


def test_a_failed_path_is_told_and_goes_on_later(tmp_path, finished, monkeypatch, capsys):
    folder = tmp_path / "run"
    hasty = functools.partial(build.ShellStructure, max_iterations=1)
    with monkeypatch.context() as patched:
        patched.setattr(build, "ShellStructure", hasty)
        assert cli.main([*RUN, "--out", str(folder)]) == 1
    message = capsys.readouterr().err
    assert "NO_EQUILIBRIUM at step 0, 0 of the load: step 1 of 10" in message
    assert "raise max_iterations" in message
    assert json.loads((folder / "run.json").read_text())["result"] == "no_equilibrium"
    assert cli.main(["resume", str(folder)]) == 0
    a, b = (read_history(f / "history.csv") for f in (folder, finished))
    assert np.array_equal(a["tip_z"], b["tip_z"])
