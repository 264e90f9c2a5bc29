"""The README examples run as printed; its two commands are those of continuous integration."""

import contextlib
import io
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


def output(example: str) -> str:
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(example, "README.md", "exec"), {})
    return stream.getvalue()


def test_shell_example(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    numbers = [float(x) for x in re.findall(r"-?\d+\.\d*(?:e-?\d+)?", output(EXAMPLES[0]))]
    assert numbers[0] == pytest.approx(-3.2894, abs=1e-3)
    assert numbers[2] == pytest.approx(6.6997, abs=1e-3)
    assert (tmp_path / "strip.vtu").exists()


def test_flow_example():
    force, torque = output(EXAMPLES[1]).strip().split("\n")
    drag = [float(x) for x in force.split()]
    assert drag == pytest.approx([0.0, 0.0, 18.8495559], rel=2e-5, abs=1e-6)
    assert float(torque) > 0.0


def test_run_example():
    assert output(EXAMPLES[2]).startswith("completed")


def test_model_adaptivity_example():
    rows = [line.split() for line in output(EXAMPLES[3]).strip().split("\n")]
    assert len(rows) > 1
    assert abs(float(rows[-1][3])) < 1e-2


def test_two_commands():
    assert "pip install -e . && airfold run pancake\n" in TEXT
    assert 'pip install -e ".[test]" && pytest\n' in TEXT
    assert 'pip install --quiet -e ".[test]" && pytest' in (ROOT / ".ci/run").read_text()
