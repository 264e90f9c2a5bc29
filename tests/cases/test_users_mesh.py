"""A user's mesh on its whole way: from the console's check to a run, its records and its resume."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from cases import cli, loader
from cases.kinds.inflation.build import simulated
from cases.kinds.inflation.config import (
    BagInflow,
    BagStructure,
    InflationScene,
    MeshGeometry,
    TriangleMesh,
)
from cases.kinds.inflation.plan import InflationPlan
from cases.output.history import read_history
from cases.output.vtk import read_frames, read_grid
from cases.sections import Time
from coupling import Result

from .geometry.meshes.awkward import AWKWARD
from .geometry.triangle_bags import raw_sphere, spheroid

SCENE = """
description = "a raw spheroid"
[geometry]
kind = "mesh"
file = "bag.stl"
unit = "mm"
inlet = {{ sphere = [0.0, 0.0, -0.5, 0.65] }}
[mesh]
degree = 2
[structure]
inflow_rim = "{rim}"
[fluid]
model = "{model}"
[inflow]
final_volume = 1.6
t1 = 4.0
t2 = 16.0
[time]
dt = 1.5
end = {end}
[output]
fields_every = 1
picture = false
[physical]
length = 0.1
thickness = 0.01
young_modulus = 1.0e6
areal_density = 1.0
viscosity = 10.0
"""


def soup(points: np.ndarray, triangles: np.ndarray) -> bytes:
    """Binary STL, every third triangle the wrong way round."""
    triangles = triangles.copy()
    triangles[::3] = triangles[::3, ::-1]
    record = np.zeros(
        len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("", "<u2")]
    )
    record["corners"] = points[triangles]
    return b"raw".ljust(80) + np.uint32(len(triangles)).tobytes() + record.tobytes()


def scene_file(
    folder: Path, *, model: str = "stokes", rim: str = "hinged", end: float = 3.0
) -> Path:
    """A scene with its mesh beside it."""
    points, triangles = raw_sphere(40)
    (folder / "bag.stl").write_bytes(soup(100.0 * points * [1.0, 1.0, 0.5], triangles))
    path = folder / "spheroid.toml"
    path.write_text(SCENE.format(model=model, rim=rim, end=end))
    return path


def test_a_run_in_stokes_flow(tmp_path, capsys):
    scene, folder = scene_file(tmp_path), tmp_path / "run"
    assert cli.main(["run", str(scene), "--out", str(folder)]) == 0
    history = read_history(folder / "history.csv")
    assert np.abs(history["volume"] / history["volume_prescribed"] - 1.0).max() < 1e-10
    # 76 triangles that turn by 50 degrees each: 4e-4; near rules of the wrong pieces: above 1e-3
    assert (np.abs(history["zeta"][1:]) / history["velocity_max"][1:]).max() < 6e-4
    assert np.allclose(np.diff(history["t"]), 1.5)  # no step was rejected
    assert history["assemblies"][1:].mean() <= 3.0
    assert "0 rejected" in capsys.readouterr().out
    # the run keeps its mesh: it goes on wherever its folder is, also without the user's file
    (tmp_path / "bag.stl").unlink()
    moved = Path(shutil.move(folder, tmp_path / "moved"))
    text = (moved / "run.toml").read_text()
    assert 'file = "geometry_file.stl"' in text
    (moved / "run.toml").write_text(text.replace("end = 3.0", "end = 4.5"))
    assert cli.main(["resume", str(moved)]) == 0
    assert read_history(moved / "history.csv")["t"][-1] == 4.5
    frames = read_frames(moved / "fields.pvd")
    assert len(frames) == 4
    assert read_grid(moved / frames[-1][1]).cells[0].type == "VTK_LAGRANGE_TRIANGLE"
    assert cli.main(["report", str(moved), "--loads"]) == 0
    assert (moved / "overview.png").stat().st_size > 20_000
    # an edited mesh is another scene
    mesh = moved / "geometry_file.stl"
    mesh.write_bytes(mesh.read_bytes()[:-50] + b"\x00" * 50)
    capsys.readouterr()
    assert cli.main(["resume", str(moved)]) == 2
    assert "another scene" in capsys.readouterr().err


def test_a_bag_in_memory_runs_coupled():
    """Own triangles in place of a scene's geometry, without any file."""
    bag = spheroid(40, 0.5, degree=2)
    scene = InflationScene(
        "own",
        geometry=MeshGeometry(),
        mesh=TriangleMesh(degree=2),
        structure=BagStructure(inflow_rim="hinged"),
        inflow=BagInflow(final_volume=1.6, t1=4.0, t2=16.0),
        time=Time(dt=1.5, end=1.5),
    )
    outcome = simulated(scene, bag).simulation().run()
    assert outcome.result is Result.COMPLETED
    assert outcome.counts["rejected"] == 0


@pytest.mark.parametrize("rim", ["hinged", "clamped"])
def test_a_run_under_pressure(tmp_path, rim):
    folder = tmp_path / "run"
    scene = scene_file(tmp_path, model="pressure", rim=rim, end=6.0)
    assert cli.main(["run", str(scene), "--out", str(folder)]) == 0
    history = read_history(folder / "history.csv")
    assert len(history["t"]) == 5
    assert (np.diff(history["pressure"]) > 0.0).all()


def test_check_tells_and_draws(tmp_path, capsys):
    picture = tmp_path / "picture.png"
    assert cli.main(["check", str(scene_file(tmp_path)), "--picture", str(picture)]) == 0
    said = capsys.readouterr().out
    for words in ("STL, 76 triangles", "welded to 40", "triangles turned", "L = 100 mm"):
        assert words in " ".join(said.split())
    assert picture.stat().st_size > 20_000


def test_check_finds_crossings(tmp_path, capsys):
    """The top of a spheroid pushed through its bottom."""
    points, triangles = raw_sphere(160)
    pushed = points * [1.0, 1.0, 0.5]
    top = np.hypot(pushed[:, 0], pushed[:, 1]) < 0.4
    pushed[top & (pushed[:, 2] > 0.0), 2] -= 1.3
    path = scene_file(tmp_path, model="pressure")
    (tmp_path / "bag.stl").write_bytes(soup(100.0 * pushed, triangles))
    overrides = ["--set", "geometry.inlet={ box = [[0.4, -1.0, -1.0], [1.0, 1.0, 1.0]] }"]
    command = ["check", str(path), *overrides, "--picture", str(tmp_path / "check.png")]
    assert cli.main(command) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "self-intersections YES" in said
    assert "the bag crosses itself" in said


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_files_end_no_command(name, tmp_path, capsys):
    """One line with a remedy and exit code 2, or a forecast."""
    path = AWKWARD[name].written(tmp_path)
    capsys.readouterr()  # what writing it has said
    scene = tmp_path / "scene.toml"
    scene.write_text(f'[geometry]\nkind = "mesh"\nfile = "{path.name}"\ninlet = "nothing"\n')
    code = cli.main(["check", str(scene), "--picture", str(tmp_path / "check.png")])
    said = capsys.readouterr()
    assert code == 2
    assert said.err.startswith("error: ")
    assert len(said.err.splitlines()) == 1


@pytest.mark.parametrize("name", ["bag-stl", "disc-deck", "pattern"])
def test_shipped_meshes(name):
    plan = InflationPlan(loader.read(name))
    assert plan.bag.notes
    assert plan.bag.inlet.n_elements >= 20
    assert plan.sizes.total > 0.0


BAD_VALUES = {  # what replaces the line of a key, and what the answer must hold
    "inlet = { sphere = [9.0, 0.0, 0.0, 1.0] }": ("bag.stl: geometry.inlet", "extends from"),
    "inlet = { plane = [0.0, 0.0, 0.0, 1.0] }": ("bag.stl: geometry.inlet.plane", "zero"),
    "inlet = { plane = [0.0, 0.0, 1.0, -9.0] }": ("bag.stl: geometry.inlet", "choose fewer"),
    'inlet = "inlt"': ("bag.stl: geometry.inlet", "'inlt'", "sphere, box or plane"),
    'inlet = "hole"': ("bag.stl: geometry.inlet", "closed"),
    "inlet = 3": ("geometry.inlet", "a string or a table of sphere, box, plane, hole", "3"),
    'rest = ["upper"]': ("bag.stl: geometry.rest", "'upper'", "leave the key out"),
    "opening = 0.1": ("bag.stl: geometry.opening = 0.1", "drop the opening"),
    "weld = 0.1": ("geometry.weld: 0.1", "below 0.1"),
    'folds = [{ at = 0.5, side = "up" }]': ("geometry.folds[0].radius: is needed",),
    'folds = [{ at = 0.5, side = "up", radius = 0.1 }]': ("bag.stl: geometry.folds", "flat"),
    "[mesh]\nsplit = 5": ("bag.stl: mesh.most: 77824", "lower mesh.split"),
    "[mesh]\nsplit = 6": ("mesh.split: 6", "at most 5"),
    "[structure]\nquadrature = 4": ("structure.quadrature: 4", "leave the key out"),
}


@pytest.mark.parametrize("line", BAD_VALUES)
def test_bad_values_are_named_with_key_or_file(line, tmp_path, capsys):
    scene = scene_file(tmp_path)
    head, _, last = line.rpartition("\n")
    place, key = head or "[geometry]", last.partition(" =")[0]
    kept = [old for old in scene.read_text().splitlines() if old.partition(" =")[0] != key]
    scene.write_text("\n".join(kept).replace(place, f"{place}\n{last}"))
    assert cli.main(["check", str(scene)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert len(said.splitlines()) == 1
    assert said.count("bag.stl") <= 1
    for words in BAD_VALUES[line]:
        assert words in said


def test_a_reference_of_another_unit_warns(tmp_path, capsys):
    scene = scene_file(tmp_path)
    points, triangles = raw_sphere(40)
    (tmp_path / "flat.stl").write_bytes(soup(200.0 * points * [1.0, 1.0, 0.5], triangles))
    command = ["check", str(scene), "--picture", str(tmp_path / "check.png"), "--set"]
    assert cli.main([*command, f"geometry.reference={tmp_path / 'flat.stl'}"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "stretched by 0.5 to 0.5 against its unfolded reference" in said
    assert cli.main([*command, f"geometry.reference={tmp_path / 'bag.stl'}"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "98% in 1 .. 1; the stress-free bag" in said
    assert "against its unfolded" not in said


def test_facets_in_a_flow_warn(tmp_path, capsys):
    scene = scene_file(tmp_path)
    command = ["check", str(scene), "--picture", str(tmp_path / "check.png")]
    assert cli.main([*command, "--set", "geometry.smooth=false"]) == 0
    assert "singular at their edges" in " ".join(capsys.readouterr().out.split())
    assert cli.main(command) == 0
    assert "singular at their edges" not in " ".join(capsys.readouterr().out.split())
