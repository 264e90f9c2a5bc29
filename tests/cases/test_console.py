"""The console with a toy build: runs, kills, resumes, messages, exit codes, light imports."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from cases import benchmarks, cli
from cases.benchmarks import report
from cases.kinds import KINDS
from cases.output.atomic import SUFFIX
from cases.output.checkpoint import load
from cases.output.history import read_history
from cases.output.vtk import read_frames

ROOT = Path(__file__).resolve().parents[2]
TOY = Path(__file__).with_name("toy.py")
RUN = ["run", "pancake"]
for _item in ("time.dt=8", "time.end=160", "output.checkpoint_every=4", "output.fields_every=3"):
    RUN += ["--set", _item]


def _rows(folder: Path) -> list[str]:
    return [line.rsplit(",", 1)[0] for line in (folder / "history.csv").read_text().splitlines()]


def _python(*arguments: str) -> subprocess.CompletedProcess:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, env=environment, check=False
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory, toy):
    """An uninterrupted toy run."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    patch = pytest.MonkeyPatch()
    patch.setitem(KINDS, "inflation", toy.ToyKind())
    code = cli.main([*RUN, "--out", str(folder)])
    patch.undo()
    assert code == 0
    return folder


def test_a_run_leaves_its_folder(whole):
    names = {path.name for path in whole.iterdir()}
    assert names == {
        "run.toml", "run.json", "history.csv", "iterations.log", "convergence.log",
        "fields.pvd", "fields", "checkpoint.npz", "overview.png", "run.lock",
    }  # fmt: skip
    assert list(read_history(whole / "history.csv"))[-1] == "wall_time"
    record = json.loads((whole / "run.json").read_text())
    assert record["result"] == "completed"
    assert record["sessions"][0]["rejections"]["COUPLING"] > 0
    assert set(record["sessions"][0]["phases"]) == {"build", "run", "picture"}


@pytest.mark.parametrize("kill_at", [1, 13, 19])
def test_kill_and_resume_gives_the_same_rows(tmp_path, whole, use, kill_at):
    folder = tmp_path / "run"
    done = _python(str(TOY), str(folder), str(kill_at))
    assert done.returncode == -9, done.stderr
    assert json.loads((folder / "run.json").read_text())["result"] == "running"
    (folder / f"checkpoint.npz{SUFFIX}").write_bytes(b"half")
    use()
    assert cli.main(["resume", str(folder)]) == 0
    assert _rows(folder) == _rows(whole)
    for name in ("iterations.log", "convergence.log", "fields.pvd", "run.toml"):
        assert (folder / name).read_text() == (whole / name).read_text()
    assert not list(folder.rglob(f"*{SUFFIX}"))


def test_killed_before_the_first_checkpoint(tmp_path, whole, use):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "run.toml").write_text((whole / "run.toml").read_text())
    (folder / "history.csv").write_text("step,t")
    use()
    assert cli.main(["resume", str(folder)]) == 0
    assert _rows(folder) == _rows(whole)


def test_interrupt_says_how_to_go_on(tmp_path, whole, use, toy, capsys):
    folder = tmp_path / "run"
    use(toy.Scheme(error_at=9, error=KeyboardInterrupt))
    assert cli.main([*RUN, "--out", str(folder)]) == 130
    step = len(_rows(folder)) - 2
    said = capsys.readouterr().out
    assert f"stopped; step {step}, t = " in said
    assert f"is saved; continue with: airfold resume {folder}" in said
    assert step % 4  # no step at which a checkpoint is made anyway
    assert load(folder / "checkpoint.npz").step == step
    assert json.loads((folder / "run.json").read_text())["result"] == "interrupted"
    use()
    assert cli.main(["resume", str(folder)]) == 0
    assert _rows(folder) == _rows(whole)


def test_a_stuck_run_says_why_in_one_line(tmp_path, use, capsys):
    use()
    folder = tmp_path / "run"
    assert cli.main([*RUN, "--set", "time.dt_floor=5", "--out", str(folder)]) == 1
    error = capsys.readouterr().err.strip()
    assert error.startswith("STEP_FLOOR at step")
    assert "\n" not in error
    assert json.loads((folder / "run.json").read_text())["result"] == "step_floor"
    assert (folder / "checkpoint.npz").exists()


def test_plain_lines_in_a_pipe_and_the_picture_last(tmp_path, use, capsys):
    use()
    assert cli.main([*RUN, "--out", str(tmp_path / "run")]) == 0
    lines = capsys.readouterr().out.splitlines()
    steps = [line for line in lines if line.startswith("step") and "V/V0" in line]
    assert len(steps) == len(read_history(tmp_path / "run" / "history.csv")["t"]) - 1
    assert lines[-1] == f"picture: {tmp_path / 'run' / 'overview.png'}"


def test_folder_in_use_and_default_folder(tmp_path, use, capsys, monkeypatch):
    use()
    (tmp_path / "file").write_text("")
    assert cli.main([*RUN, "--out", str(tmp_path)]) == 2
    assert "not empty; choose another --out" in capsys.readouterr().err
    monkeypatch.chdir(tmp_path)
    for n in (1, 2):
        assert cli.main([*RUN, "--set", "output.fields_every=0"]) == 0
        assert (tmp_path / "runs" / f"pancake-{n}" / "history.csv").exists()
    skips = json.loads((tmp_path / "runs" / "pancake-1" / "run.json").read_text())["skips"]
    assert any(skip.startswith("overview.png") for skip in skips)


def test_resume_and_report_want_a_run(tmp_path, whole, use, capsys):
    assert cli.main(["resume", str(tmp_path)]) == 2
    assert cli.main(["report", str(tmp_path)]) == 2
    picture = whole / "overview.png"
    picture.unlink()
    assert cli.main(["report", str(whole)]) == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_report_puts_a_run_beside_another(tmp_path, whole, use, capsys):
    use()
    other = tmp_path / "run"
    cli.main([*RUN, "--set", "fluid.model='pressure'", "--out", str(other)])
    assert cli.main(["report", str(whole), "--beside", str(other)]) == 0
    assert (whole / "beside.png").read_bytes()[:4] == b"\x89PNG"
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("V/V0 = ") for line in lines) == 5
    assert lines[-1] == "keys that differ: fluid.model"
    assert cli.main(["report", str(whole), "--beside", str(tmp_path)]) == 2
    assert "holds no history.csv" in capsys.readouterr().err


def test_resume_refuses_a_changed_scene(tmp_path, use, capsys):
    use()
    folder = tmp_path / "run"
    cli.main([*RUN, "--out", str(folder)])
    text = (folder / "run.toml").read_text()
    (folder / "run.toml").write_text(text.replace("mass_ratio = 0.005", "mass_ratio = 0.006"))
    assert cli.main(["resume", str(folder)]) == 2
    assert "belongs to another scene" in capsys.readouterr().err
    (folder / "run.toml").write_text(text.replace("end = 160.0", "end = 176.0"))
    assert cli.main(["resume", str(folder)]) == 0
    assert read_frames(folder / "fields.pvd")[-1][0] == 176.0


def test_check_prints_the_forecast(monkeypatch, capsys):
    item = SimpleNamespace(name="rho", value=0.48123, unit="", note="m dt S")
    warnings = ["rho = 7.8 > 1: use scheme 'implicit'"]
    forecast = SimpleNamespace(items=[item], warnings=warnings, picture=None, notes=[])
    fake = dataclasses.replace(KINDS["inflation"])
    object.__setattr__(fake, "forecast", lambda scene: forecast)
    monkeypatch.setitem(KINDS, "inflation", fake)
    assert cli.main(["check", "pancake"]) == 0
    out = capsys.readouterr().out
    assert "0.4812" in out
    assert "warning: rho = 7.8 > 1" in out


def test_list_and_help(capsys):
    assert cli.main(["list"]) == 0
    assert "pancake-pressure" in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        cli.main(["--help"])
    assert ended.value.code == 0
    with pytest.raises(SystemExit) as ended:
        cli.main(["inflate"])
    assert ended.value.code == 2


def test_unknown_benchmark_names_the_valid_ones(monkeypatch, capsys):
    entry = benchmarks.Entry("toy_benchmark", "nothing")
    monkeypatch.setattr(benchmarks, "BENCHMARKS", {"toy": entry})
    assert cli.main(["bench", "unknown"]) == 2
    assert "valid: toy" in capsys.readouterr().err


def test_benchmark_rows_are_calibrated(tmp_path, monkeypatch, capsys):
    rows = [{"case": "a", "n": 3, "seconds": 2.0, "error": 1e-3}]
    fake = SimpleNamespace(run=lambda quick: rows, pairs=lambda: 10)
    monkeypatch.setitem(sys.modules, "toy_benchmark", fake)
    file = tmp_path / "rows.json"
    report.execute("toy", "toy_benchmark", True, file)
    written = json.loads(file.read_text())
    speed = written["machine"]["dgemm_gflops"]
    assert written["rows"][0]["gflop"] == pytest.approx(2.0 * speed)
    assert written["benchmark"] == "toy"
    assert "stokeslet_pairs_per_s" in written["machine"]
    with pytest.raises(KeyError, match="error"):
        report.calibrated([{"case": "a", "seconds": 1.0}], {"dgemm_gflops": 1.0})


def test_a_broken_benchmark_leaves_its_rows(tmp_path, monkeypatch):
    def run(quick):
        yield {"case": "a", "seconds": 2.0, "error": 1e-3}
        raise RuntimeError("broken off")

    monkeypatch.setitem(sys.modules, "toy_benchmark", SimpleNamespace(run=run))
    file = tmp_path / "rows.json"
    with pytest.raises(RuntimeError, match="broken off"):
        report.execute("toy", "toy_benchmark", True, file)
    assert [row["case"] for row in json.loads(file.read_text())["rows"]] == ["a"]


@pytest.mark.parametrize("arguments", ["--help", "list", "check missing.toml"])
def test_light_commands_stay_light(arguments):
    code = f"""
import sys
from cases import cli
try:
    cli.main({arguments.split()!r})
except SystemExit:
    pass
heavy = [m for m in ("numba", "skfem", "matplotlib", "meshio", "scipy") if m in sys.modules]
print("heavy:", heavy)
"""
    assert _python("-c", code).stdout.splitlines()[-1] == "heavy: []"
