"""Kernels compiled ahead of a run: all that it needs, only where none are kept, and no must."""

import io
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

from rich.console import Console

from cases import loader
from cases.runs import _compile_kernels as ahead

ROOT = Path(__file__).resolve().parents[3]
COVERED = """
import sys
from cases import loader
from cases.kinds import simulation
from cases.runs._compile_kernels import REHEARSALS

def compiled():
    return {
        f"{name}.{key}{signature}"
        for name, module in list(sys.modules.items()) if name.startswith(("hbem.", "shells."))
        for key, value in vars(module).items() for signature in getattr(value, "signatures", [])
    }

for rehearse in REHEARSALS.values():
    rehearse(2)
before = compiled()
small = ["mesh.degree=2", "mesh.around=8", "time.dt=32", "time.end=32", "fluid.outer_points=2"]
simulation(loader.read("pancake", small)).run()
print(len(before), sorted(compiled() - before))
"""


def test_a_run_compiles_nothing_more():
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", COVERED]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    count, _, more = done.stdout.partition(" ")
    assert int(count) > 8, done.stderr  # callees have no signature where files serve
    assert more.strip() == "[]"


def test_cold_are_kernels_without_a_file_or_with_an_older_one(tmp_path, monkeypatch):
    kernel = SimpleNamespace(
        py_func=test_a_run_compiles_nothing_more,
        stats=SimpleNamespace(cache_path=str(tmp_path / "cache")),
    )
    monkeypatch.setattr(ahead, "import_module", lambda name: SimpleNamespace(one=kernel))
    assert ahead._is_cold("module", "one")
    tag = "py{}{}".format(*sys.version_info)
    file = tmp_path / "cache" / f"{Path(__file__).stem}.one-1.{tag}.nbi"
    file.parent.mkdir()
    file.touch()
    assert not ahead._is_cold("module", "one")
    os.utime(file, (0, 0))
    assert ahead._is_cold("module", "one")
    del kernel.stats  # without the compiler
    assert not ahead._is_cold("module", "one")


def test_a_process_that_fails_is_told(monkeypatch):
    console = Console(file=io.StringIO(), width=100)
    ahead._side_by_side([["no share"]], 2, console)
    monkeypatch.setattr(ahead.sys, "executable", str(ROOT / "no python"))
    ahead._side_by_side([["no share"]], 2, console)
    said = console.file.getvalue()
    assert said.count("a process failed; the run compiles the rest") == 2


def test_kernels_that_a_run_compiles_are_told(monkeypatch):
    console = Console(file=io.StringIO(), width=100)
    monkeypatch.setattr(ahead, "_is_cold", lambda module, name: False)
    with ahead.kernels_ready(loader.read("pancake"), console):
        ahead.event.start_event("numba:compile", {"dispatcher": SimpleNamespace(__name__="one")})
    assert console.file.getvalue() == "compiling kernels: number 1, one\n"
