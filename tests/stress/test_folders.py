"""Run folders under attack: each trial ends as it should or in one message, and nothing is lost."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from cases import machine
from cases.benchmarks.honesty import folders

ROOT = Path(__file__).resolve().parents[2]
LEAST = {
    "damaged folder": (55, 600),
    "bit flip": (100, 3000),
    "report of a damaged folder": (3, 100),
    "refused place": (4, 4),
    "refused name": (8, 8),
    "two writers": (5, 5),
    "console": (5, 5),
}
POSIX = {"read-only folder": (5, 5), "full disk": (8, 48), "stopped": (1, 12), "killed": (1, 20)}
if os.name == "posix":
    LEAST |= POSIX


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_no_trial_breaks_a_folder(quick):
    trials = folders.trials(quick)
    assert [trial for trial in trials if trial["silent"] or not trial["held"]] == []
    tried = Counter(trial["promise"] for trial in trials)
    assert {name: n for name, n in tried.items() if n < LEAST[name][not quick]} == {}
    assert tried.keys() == LEAST.keys()


def test_machine_code_has_a_place_of_its_own(tmp_path, monkeypatch):
    """Where neither the modules nor the home can be written to."""
    import tempfile

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    machine.keep_compiled_code()
    assert "NUMBA_CACHE_DIR" not in os.environ
    monkeypatch.setattr(machine, "_writable", lambda folder: False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "given")
    machine.keep_compiled_code()
    assert os.environ["NUMBA_CACHE_DIR"] == "given"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    machine.keep_compiled_code()
    first = Path(os.environ["NUMBA_CACHE_DIR"])
    assert first.parent == tmp_path
    assert first.is_dir()
    if os.name == "posix":
        first.chmod(0o777)  # anybody may have put code there
        monkeypatch.delenv("NUMBA_CACHE_DIR")
        machine.keep_compiled_code()
        assert Path(os.environ["NUMBA_CACHE_DIR"]) not in (first, tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("setpriv") is None, reason="needs setpriv to give up rights")
def test_a_read_only_installation_runs(tmp_path):
    tree = tmp_path / "tree"
    for package in ("shells", "hbem", "coupling", "cases"):
        leave = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tree / package, ignore=leave)
    for path in (*tree.rglob("*"), tree):
        path.chmod(0o555 if path.is_dir() else 0o444)
    rights = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    run = [
        "run",
        "cantilever-shear",
        "--set",
        "load.steps=2",
        "--set",
        "output.picture=false",
        "--out",
        str(tmp_path / "run"),
    ]
    here = {"HOME": "/proc/nobody", "TMPDIR": str(tmp_path), "PYTHONPATH": str(tree)}
    done = subprocess.run(
        [*rights, sys.executable, "-m", "cases.cli", *run],
        cwd=tmp_path,
        env={**os.environ, "XDG_CACHE_HOME": "", **here},
        capture_output=True,
        text=True,
        check=False,
    )
    for path in (tree, *tree.rglob("*")):
        path.chmod(0o755)
    assert (done.returncode, done.stderr) == (0, "")
    assert list(tmp_path.glob("airfold-numba-*/*"))
