"""Every example of every README runs as printed; commands, links and generated parts are right."""

import contextlib
import io
import re
import tomllib
from pathlib import Path

import pytest

from cases import loader
from cases.kinds.inflation.plan import InflationPlan
from cases.scenes import gallery

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("", "shells", "hbem", "coupling", "cases", "cases/scenes", "cases/benchmarks")
READMES = [path for folder in FOLDERS if (path := ROOT / folder / "README.md").exists()]
TEXT = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in READMES}
EXAMPLES = {
    f"{name}-{i}": code
    for name, text in TEXT.items()
    for i, code in enumerate(re.findall(r"```python\n(.*?)```", text, re.DOTALL))
}
TWO_COMMANDS = ["pip install -e . && airfold run pancake", 'pip install -e ".[test]" && pytest']


def shells(output: str) -> None:
    ok, *tip = output.split()
    assert ok == "True"
    published = [-3.286, 0.0, 6.698]  # Sze, Liu, Lo (2004), four digits
    assert [float(x) for x in tip] == pytest.approx(published, abs=5e-3)


def drag(output: str) -> None:
    force = [float(x) for x in output.split()]
    assert force == pytest.approx([0.0, 0.0, 18.8495559], rel=2e-5, abs=1e-6)  # 6 pi


def adaptivity(output: str) -> None:
    errors = [abs(float(line.split()[3])) for line in output.strip().split("\n")]
    assert len(errors) > 1
    assert errors[-1] < 1e-2  # the tolerance of the example


def completed(output: str) -> None:
    assert output.strip().split("\n")[-1].startswith("completed")


EXACT = {
    "README.md-0": shells,
    "README.md-1": drag,
    "README.md-2": adaptivity,
    "README.md-3": completed,
    "cases/README.md-0": completed,  # a bag from a file
    "cases/README.md-1": completed,
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_example(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(EXAMPLES[name], name, "exec"), {"__name__": "example"})
    EXACT.get(name, str)(stream.getvalue())


def test_a_package_has_an_example_each():
    assert set(EXACT) <= set(EXAMPLES)


def test_two_commands():
    blocks = re.findall(r"```\n(.*?)\n```", TEXT["README.md"].split("\n## ")[0], re.DOTALL)
    assert blocks == TWO_COMMANDS
    assert 'pip install --quiet -e ".[test]" && pytest' in (ROOT / ".ci/run").read_text()


def test_short():
    assert len(TEXT["README.md"].splitlines()) <= 150


@pytest.mark.parametrize("name", TEXT)
def test_links(name):
    """Relative links and pictures exist; anchors are headings of their file."""
    for link in re.findall(r"\]\(([^)\s]+)\)", TEXT[name]):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (ROOT / name).parent / path if path else ROOT / name
        assert target.exists(), link
        if anchor:
            assert anchor in headings(target), link


def headings(path: Path) -> set[str]:
    """Anchors as GitHub makes them."""
    lines = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


def test_scene_of_the_readme(tmp_path):
    block, mesh = re.findall(r"```toml\n(.*?)```", TEXT["cases/README.md"], re.DOTALL)
    (tmp_path / "scene.toml").write_text(block)
    assert loader.read(tmp_path / "scene.toml").geometry.kind == "pillow"
    assert tomllib.loads(block)["kind"] == "inflation"
    (tmp_path / "mesh.toml").write_text(mesh)
    (tmp_path / "bag.stl").write_bytes((ROOT / "cases/scenes/meshes/bag.stl").read_bytes())
    assert InflationPlan(loader.runnable(tmp_path / "mesh.toml")).bag.inlet.n_elements == 24


def test_gallery_is_complete():
    records = gallery.read()
    assert sorted(records) == sorted(loader.shipped())
    for name in records:
        assert (gallery.PICTURES / f"{name}.png").stat().st_size <= gallery.BYTES, name


def test_generated_parts():
    for path, text in gallery.pages():
        assert path.read_text(encoding="utf-8") == text, f"{path}: write it by cases.scenes.gallery"


def test_a_reduced_run_shows_its_command():
    scene = loader.read("pancake", ["time.end=64", "fluid.model=pressure"])
    assert list(gallery.changes(scene)) == ['fluid.model="pressure"', "time.end=64.0"]
    entry = {"command": "airfold run pancake --set time.end=64.0", "result": "completed"}
    entry |= {"counts": {"steps": 4}, "t": 64.0, "end": 800.0, "advice": "completed"}
    assert gallery.ending(entry) == "reduced run, completed after 4 steps, at t = 64 of 800"
