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


def test_shell_example():
    word, pressure = output(EXAMPLES[0]).split()
    assert word == "converged"
    assert float(pressure) > 0.0


def test_sphere_example():
    drag = [float(x) for x in output(EXAMPLES[1]).strip(" []\n").split()]
    assert drag == pytest.approx([0.0, 0.0, 18.8495559], rel=3e-6, abs=1e-9)


def test_run_example():
    assert output(EXAMPLES[2]).startswith("completed")


def test_two_commands():
    assert "pip install -e . && airfold run pancake\n" in TEXT
    assert 'pip install -e ".[test]" && pytest\n' in TEXT
    assert 'pip install --quiet -e ".[test]" && pytest' in (ROOT / ".ci/run").read_text()
