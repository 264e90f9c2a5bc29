"""Recorders one by one: files stay valid, are cut back, and read back exactly."""

from __future__ import annotations

import json
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

from cases import loader
from cases.output import checkpoint, figures, history, iterations, vtk
from cases.output.atomic import SUFFIX, RecordError, replacing
from cases.output.run_record import RunRecord
from cases.output.seals import Seals
from coupling import AcceptedStep, Iteration, Outcome, Rejection, Result, Snapshot, State


def _step(n, **row):
    x = np.full((32, 3), float(n))
    row = {"step": n, "t": 0.1 * n, "volume": 1.0 / 3.0, "wall_time": 1.0, **row}
    traction = SimpleNamespace(coefficients=x, zeta=0.0)
    return AcceptedStep(n, State(0.1 * n, x, x, 0.0), row, traction)


def _snapshot():
    rng = np.random.default_rng(1)
    state = State(np.pi, rng.standard_normal((5, 3)), rng.standard_normal((5, 3)), 1e-300)
    memory = {"factor": np.array(0.1), "load": rng.standard_normal(7), "n": np.array([1, 2])}
    return Snapshot(7, 0.1, state, {"work": 1.0 / 3.0}, memory)


def test_replacing_leaves_the_old_file_on_error(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), replacing(path) as file:
        file.write(f"half {1 / 0}")
    assert path.read_text() == "old"


def _again(folder, mark):
    """Seals as a checkpoint made of a mark holds them."""
    return Seals(folder, Seals(folder).arrays(mark))


def test_history_keeps_17_digits_and_is_cut_back(tmp_path):
    path = tmp_path / "history.csv"
    recorder = history.History(path)
    recorder.on_start(_step(0))
    for n in (1, 2):
        recorder.on_accepted(_step(n))
    seals = _again(tmp_path, Seals(tmp_path).mark())
    recorder.on_accepted(_step(3))
    columns = history.read_history(path)
    assert list(columns) == ["step", "t", "volume", "wall_time"]
    assert columns["volume"][3] == 1.0 / 3.0
    assert columns["t"][3] == 0.1 * 3
    with open(path, "a") as file:
        file.write("4,0.4")  # a torn line
    assert history.read_history(path)["step"].tolist() == [0, 1, 2, 3]
    seals.restore()
    assert path.read_text().splitlines()[-1].startswith("2,")
    with pytest.raises(RecordError, match="other columns"):
        history.History(path).on_accepted(_step(3, more=1.0))
    history.History(path).on_accepted(_step(3))
    assert history.read_history(path)["step"].tolist() == [0, 1, 2, 3]
    Seals(tmp_path).restore()
    assert not path.exists()


@pytest.mark.parametrize("damage", ["4,0.4\n", "4,x,y,z\n", "\n", "\xff\n"])
def test_a_damaged_history_is_named(tmp_path, damage):
    path = tmp_path / "history.csv"
    history.History(path).on_start(_step(0))
    with open(path, "a", encoding="latin-1") as file:
        file.write(damage)
    with pytest.raises(RecordError, match=r"history\.csv is damaged"):
        history.read_history(path)


def test_history_adds_si_columns_before_the_wall_time(tmp_path):
    text = "[physical]\nlength = 2\nthickness = 0.01\nyoung_modulus = 1e6\nareal_density = 1\n"
    scene = tmp_path / "scene.toml"
    scene.write_text(text + "viscosity = 1\n")
    physical = loader.read(scene).physical
    recorder = history.History(tmp_path / "history.csv", physical)
    recorder.on_start(_step(1))
    columns = history.read_history(tmp_path / "history.csv")
    assert list(columns)[-3:] == ["t_si", "volume_si", "wall_time"]
    assert columns["volume_si"][0] == pytest.approx(8.0 / 3.0, rel=1e-15)
    assert columns["t_si"][0] == pytest.approx(0.1 * physical.time_unit, rel=1e-15)


def test_iteration_logs(tmp_path):
    recorder = iterations.Iterations(tmp_path)
    recorder.on_iteration(Iteration(1, 0.1, 0.1, 1, 0.5, 1.0, False))
    recorder.on_rejected(Rejection(1, 0.1, 0.1, Result.COUPLING, 1))
    for n in (1, 2):
        for k in (1, 2):
            recorder.on_iteration(Iteration(n, 0.1 * n, 0.1, k, 10.0**-k, 0.7, k == 2))
        recorder.on_accepted(_step(n, subiterations=2, dt=0.1))
        if n == 1:
            mark = Seals(tmp_path).mark()
    before = (tmp_path / "iterations.log").read_text()
    rows = [line.split() for line in before.splitlines()[1:]]
    assert [row[:4] for row in rows] == [
        ["1", "1", "1", "0"],
        ["1", "3", "2", "1"],
        ["2", "5", "2", "1"],
    ]
    assert rows[0][-1] == "COUPLING"
    again = iterations.Iterations(tmp_path)
    _again(tmp_path, mark).restore()
    again.take_up()
    assert len((tmp_path / "convergence.log").read_text().splitlines()) == 1 + 3
    for k in (1, 2):
        again.on_iteration(Iteration(2, 0.2, 0.1, k, 10.0**-k, 0.7, k == 2))
    again.on_accepted(_step(2, subiterations=2, dt=0.1))
    assert (tmp_path / "iterations.log").read_text() == before


def test_checkpoint_reads_back_exactly(tmp_path):
    path, snapshot = tmp_path / "checkpoint.npz", _snapshot()
    checkpoint.save(path, snapshot, "hash")
    back = checkpoint.load(path, "hash")
    assert (back.step, back.dt, back.accumulated) == (7, 0.1, snapshot.accumulated)
    assert (back.state.t, back.state.pressure) == (np.pi, 1e-300)
    assert np.array_equal(back.state.coefficients, snapshot.state.coefficients)
    assert np.array_equal(back.state.velocity, snapshot.state.velocity)
    assert list(back.memory) == list(snapshot.memory)
    for name, value in snapshot.memory.items():
        assert np.array_equal(back.memory[name], value)
        assert back.memory[name].dtype == value.dtype


def test_checkpoint_survives_an_interrupted_write(tmp_path, monkeypatch):
    path, snapshot = tmp_path / "checkpoint.npz", _snapshot()
    checkpoint.save(path, snapshot)

    def torn(file, **arrays):
        file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(checkpoint.np, "savez", torn)
    with pytest.raises(KeyboardInterrupt):
        checkpoint.save(path, snapshot)
    assert checkpoint.load(path).step == 7
    assert path.with_name(path.name + SUFFIX).read_bytes() == b"half"


def test_checkpoint_refuses_other_scenes_rubbish_and_objects(tmp_path):
    path, scene = tmp_path / "checkpoint.npz", loader.read("pancake")
    checkpoint.save(path, _snapshot(), checkpoint.scene_hash(scene))
    longer = loader.read("pancake", ["time.end=900", "output.fields_every=1"])
    checkpoint.load(path, checkpoint.scene_hash(longer))
    other = loader.read("pancake", ["time.dt=8"])
    with pytest.raises(RecordError, match="another scene"):
        checkpoint.load(path, checkpoint.scene_hash(other))
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(RecordError, match="cannot be continued from"):
        checkpoint.load(path)
    odd = Snapshot(1, 1.0, _snapshot().state, {}, {"x": object()})
    with pytest.raises(TypeError, match=r"memory\.x"):
        checkpoint.save(path, odd)


def test_fields_open_with_meshio_and_are_cut_back(tmp_path, toy):
    path = tmp_path / "fields.pvd"

    def recorder(seals):
        return vtk.Fields(path, toy.Sampler(), seals.frames, every=2, tessellate=1, traction=True)

    seals = Seals(tmp_path)
    first = recorder(seals)
    first.on_start(AcceptedStep(0, _step(0).state, {}, None))
    for n in range(1, 6):
        first.on_accepted(_step(n))
        if n == 2:
            mark = seals.mark()
    first.close(Outcome(Result.COMPLETED, 5, 0.5, {}))
    frames = vtk.read_frames(path)
    assert [t for t, _ in frames] == [0.0, 0.1 * 2, 0.1 * 4, 0.1 * 5]
    meshes = [meshio.read(tmp_path / name) for _, name in frames]
    assert np.array_equal(meshes[3].point_data["traction"], np.full((32, 3), 5.0))
    assert not meshes[0].point_data["traction"].any()
    assert meshes[1].cells_dict["quad"].shape == (24, 4)
    back = Seals(tmp_path, seals.arrays(mark))
    with pytest.raises(RecordError, match=r"does not know history\.csv"):
        back.verify()
    back.restore()
    recorder(back).on_accepted(_step(4))
    assert vtk.read_frames(path) == frames[:3]
    assert len(list((tmp_path / "fields").iterdir())) == 3


@pytest.mark.parametrize("name", ["../x.vtu", "/x.vtu", "C:\\x.vtu", "a\\..\\..\\x.vtu", "", "."])
def test_names_that_lead_out_of_the_folder(tmp_path, name):
    vtk.write_frames(tmp_path / "fields.pvd", [(0.0, name)])
    with pytest.raises(RecordError, match="leads out of"):
        vtk.read_frames(tmp_path / "fields.pvd")


def test_run_record_adds_sessions(tmp_path):
    scene = loader.read("pancake")
    for _ in range(2):
        record = RunRecord(tmp_path / "run.json", scene, {"quadrature": 1e-5})
        with record.phase("run"):
            pass
        record.skip("something")
        record.on_checkpoint(_snapshot())
        assert json.loads((tmp_path / "run.json").read_text())["result"] == "running"
        record.close(Outcome(Result.COMPLETED, 5, 0.5, {"assemblies": 3}, "completed"))
    written = json.loads((tmp_path / "run.json").read_text())
    assert written["result"] == "completed"
    assert written["tolerances"]["quadrature"] == 1e-5
    assert written["skips"] == ["something"]
    assert [s["counts"]["assemblies"] for s in written["sessions"]] == [3, 3]
    assert {"numpy", "scipy", "numba", "scikit-fem", "airfold"} <= set(written["versions"])


def test_cutting_a_tube_open(toy):
    grid = toy.Sampler().surface_grid(toy.initial(), velocity=np.ones((32, 3)))
    for turn in (0.0, 0.3):  # vertices on the plane, and quadrilaterals across it
        c, s = np.cos(turn), np.sin(turn)
        points = grid["points"] @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        polygons, values = figures.clipped(points, grid["quads"], np.ones(32))
        assert min(polygon[:, 1].min() for polygon in polygons) >= 0.0
        assert np.allclose(values, 1.0)
        cut = figures.section(points, grid["quads"])
        assert np.all(cut[:, :, 1] == 0.0)
        length = np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1).sum()
        assert length == pytest.approx(2 * (toy.ROWS - 1), rel=1e-12)
