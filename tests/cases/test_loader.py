"""Scenes: strictness, messages, overrides, round trip, physical units."""

from __future__ import annotations

import math
import re

import pytest

from cases import cli, loader
from cases.input_file import with_own_files
from cases.kinds import KINDS
from cases.kinds.inflation.config import InflationScene
from cases.output.checkpoint import scene_hash
from cases.scene_text import write
from cases.sections import SceneError

PHYSICAL = """
[physical]
length = 0.3
thickness = 3e-4
young_modulus = 2.5e8
areal_density = 0.25
viscosity = 1.8e-2
poisson_ratio = 0.3
"""


def _file(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return path


def _errors(tmp_path, text, *overrides):
    with pytest.raises(loader.SceneError) as caught:
        loader.read(_file(tmp_path, text), overrides)
    return caught.value.errors


def test_shipped_scenes_load_and_are_the_agreed_ones():
    assert {"pancake", "pancake-20", "pancake-pressure"} <= set(loader.shipped())
    scenes = {name: loader.read(name) for name in loader.shipped()}
    assert {name: scene.name for name, scene in scenes.items()} == {n: n for n in scenes}
    assert scenes["pancake"].fluid.mass_ratio == 0.005
    wide = scenes["pancake-20"]
    assert (wide.geometry.half_width, wide.mesh.flat_max, wide.mesh.pole) == (20.0, 4.0, 3.0)
    assert (wide.inflow.t1, wide.inflow.t2, wide.time.end, wide.time.dt) == (400, 800, 1600, 16)
    assert scenes["pancake-pressure"].fluid.model == "pressure"


def test_unknown_key_names_its_path_and_the_nearest(tmp_path):
    (error,) = _errors(tmp_path, "[structure]\nflexural_rigidty = 1.0\n")
    assert error == "structure.flexural_rigidty: unknown key, did you mean 'flexural_rigidity'?"


def test_all_problems_at_once(tmp_path):
    text = """
    description = 3
    [structure]
    flexural_rigidity = -1e-2
    stiffness = true
    poisson_ratio = nan
    [fluid]
    polar = [8, 1.5]
    outer_points = 7
    [time]
    dt = "long"
    [geometry]
    half_width = 2
    [inflw]
    """
    errors = _errors(tmp_path, text)
    paths = {error.split(":")[0] for error in errors}
    assert paths == {
        "description",
        "structure.flexural_rigidity",
        "structure.stiffness",
        "structure.poisson_ratio",
        "fluid.polar[1]",
        "fluid.outer_points",
        "time.dt",
        "geometry.half_width",
        "inflw",
    }
    assert len(errors) == len(paths)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[structure]\nflexural_rigidity = -1.0",
            "structure.flexural_rigidity: -1.0 must be at least 0",
        ),
        (
            "[structure]\nflexural_rigidity = 0",
            "structure.flexural_rigidity: 0 lets a compressed sheet crumple",
        ),
        (
            '[structure]\nlaw = "tension-field"\nflexural_rigidity = 0\ncompression_share = 0',
            "structure.compression_share: 0 without flexural rigidity",
        ),
        ("[mesh]\ndisc = 0", "mesh.disc: 0 must be at least 1"),
        ('[geometry]\nkind = "sphere"', "geometry.kind: \"sphere\" is none of 'pancake', 'pillow'"),
        ('[mesh]\ndegree = 2\njoints = "double"', "mesh.joints: 'double' knots on degree 2"),
        ("[inflow]\nt1 = 5\nt2 = 4", "inflow.t2: 4 lies before the end of the ramp"),
        ("[time]\ndt = 8\nend = 4", "time.end: 4 is less than one step"),
        ("[fluid]\nviscosity_ratio = 0", "fluid.viscosity_ratio: 0.0 must be at least 1e-06"),
        ("[output]\npicture = 1", "output.picture: must be true or false, not 1"),
        ("[time]\ndt = true", "time.dt: must be a number, not true"),
        ("[time]\ndt = inf", "time.dt: must be finite"),
        ("[mesh]\naround = 8.0", "mesh.around: must be a whole number, not 8.0"),
        ("time = 3", "time: must be a section [time], not 3"),
        ("[time]\ndt = x\n", "unreadable TOML: Invalid value (at line 2"),
    ],
)
def test_bad_scene_ends_the_console_with_2(tmp_path, capsys, text, message):
    assert cli.main(["run", str(_file(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_missing_scene_suggests_one():
    with pytest.raises(loader.SceneError, match="did you mean 'pancake'"):
        loader.read("pancak")
    with pytest.raises(loader.SceneError, match="cannot be read"):
        loader.read("nowhere/scene.toml")


def test_overrides_are_toml_values_or_bare_strings():
    scene = loader.read(
        "pancake",
        ["time.dt=4", "coupling.scheme=aitken", "fluid.polar=[6, 7]", "output.picture=false"],
    )
    assert scene.time.dt == 4.0
    assert isinstance(scene.time.dt, float)
    assert scene.coupling.scheme == "aitken"
    assert scene.fluid.polar == (6, 7)
    assert scene.output.picture is False


def test_bad_overrides_are_all_reported():
    with pytest.raises(loader.SceneError) as caught:
        loader.read("pancake", ["time.dt", "time.dd=3", "name.x=1", "fluid.model=stoke"])
    text = str(caught.value)
    for part in (
        '--set "time.dt": expected',
        "time.dd: unknown",
        "name: must be a string, not a section",
        '"stoke" is none',
    ):
        assert part in text


@pytest.mark.parametrize("name", ["pancake", "pancake-20", "pancake-pressure"])
def test_round_trip_is_exact(tmp_path, name):
    scene = loader.read(name, ["time.dt=0.1", 'description="a \\"b\\" \\\\ é\\n"'])
    assert loader.read(_file(tmp_path, write(scene))) == scene


def test_physical_table_determines_the_groups(tmp_path):
    scene = loader.read(_file(tmp_path, PHYSICAL))
    stiffness = 2.5e8 * 3e-4 / (1 - 0.3**2)
    time_unit = 0.3 * math.sqrt(0.25 / stiffness)
    pressure_unit = stiffness / 0.3
    assert scene.physical.time_unit == pytest.approx(time_unit, rel=1e-14)
    assert scene.physical.pressure_unit == pytest.approx(pressure_unit, rel=1e-14)
    assert scene.structure.flexural_rigidity == pytest.approx(1e-6 / 12, rel=1e-14)
    assert scene.structure.poisson_ratio == 0.3
    assert scene.fluid.mass_ratio == pytest.approx(1.8e-2 / (pressure_unit * time_unit), rel=1e-14)
    assert loader.read(_file(tmp_path, write(scene))) == scene


def test_physical_and_dimensionless_values_exclude_each_other(tmp_path):
    errors = _errors(tmp_path, PHYSICAL + "[fluid]\nmass_ratio = 0.1\n")
    assert errors == ["fluid.mass_ratio: follows from physical.viscosity; give one of the two"]
    errors = _errors(tmp_path, "[physical]\nlength = 1.0\n")
    assert "physical.thickness: is needed in [physical]" in errors


def test_defaults_are_valid():
    assert loader.read("pancake").mesh == InflationScene("x").mesh


@pytest.mark.parametrize(
    ("scene", "override", "message"),
    [
        (
            "pancake",
            "geometry.fold=roll",
            "= 'pillow', not to \"pancake\"",
        ),
        ("pillow", "geometry.half_width=3", "belongs to geometry.kind = 'pancake'"),
        ("pillow", "mesh.rim=9", "belongs to geometry.kind = 'pancake'"),
        ("planar-stokes-fold", "geometry.width=9", "belongs to geometry.kind = 'pancake'"),
        ("cantilever-shear", "geometry.inner=2", "belongs to geometry.kind = 'annulus'"),
        ("cantilever-shear", "load.moment=2", "belongs to load.kind = 'moment'"),
        ("cavity-re10", "goal.radius=0.2", "belongs to goal.kind = 'velocity'"),
    ],
)
def test_keys_of_another_shape_are_refused(scene, override, message):
    with pytest.raises(loader.SceneError, match=re.escape(message)):
        loader.read(scene, [override])


def test_another_shape_on_the_command_line_replaces_the_files(tmp_path):
    scene = loader.read("pancake", ["mesh.around=16", "geometry.kind=pillow"])
    assert (scene.geometry.kind, scene.geometry.fold, scene.mesh.around) == ("pillow", "flat", 16)
    assert loader.read(_file(tmp_path, write(scene))) == scene
    assert "half_width" not in write(scene)


def test_every_shape_is_valid_by_default(tmp_path):
    (tmp_path / "bag.stl").write_bytes(b"")
    for kind in KINDS.values():
        for section in kind.sections.values():
            for word in getattr(section, "tables", ()):
                head, key = section.key.split(".")
                text = f'kind = "{kind.name}"\n[{head}]\n{key} = "{word}"\n'
                text += 'file = "bag.stl"\n' if word == "mesh" else ""
                loader.read(_file(tmp_path, text))


MESH = 'kind = "inflation"\n[geometry]\nkind = "mesh"\nfile = "bag.stl"\n'


def test_files_count_from_the_scene_and_read_back(tmp_path, monkeypatch):
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    home.mkdir()
    elsewhere.mkdir()
    (home / "bag.stl").write_bytes(b"one")
    (elsewhere / "other.stl").write_bytes(b"two")
    monkeypatch.chdir(elsewhere)
    one, two = (f'{{ at = {x}, side = "{side}", radius = 0.02 }}'
                for x, side in ((0.3, "up"), (0.6, "down")))  # fmt: skip
    folds = f"folds = [{one}, {two}]\n"
    inlet = "inlet = { sphere = [0.0, 0.0, -1.0, 0.3] }\n"
    scene = loader.read(_file(home, MESH + folds + inlet))
    g = scene.geometry
    assert g.file.path == home / "bag.stl"
    assert g.inlet.sphere == (0.0, 0.0, -1.0, 0.3)
    assert [(f.at, f.side) for f in g.folds] == [(0.3, "up"), (0.6, "down")]
    assert loader.read(_file(home, write(scene))) == scene
    assert loader.read(home / "scene.toml", ["geometry.file=other.stl"]).geometry.file.path == (
        elsewhere / "other.stl"
    )
    # a run keeps its own copy: it is the same scene wherever its folder goes, and knows a change
    own = with_own_files(scene, elsewhere)
    (tmp_path / "moved").mkdir()
    _file(elsewhere, write(own))
    for name in ("geometry_file.stl", "scene.toml"):
        (tmp_path / "moved" / name).write_bytes((elsewhere / name).read_bytes())
    moved = loader.read(tmp_path / "moved" / "scene.toml")
    assert scene_hash(moved) == scene_hash(own)
    (tmp_path / "moved" / "geometry_file.stl").write_bytes(b"edited")
    edited = loader.read(tmp_path / "moved" / "scene.toml")
    assert scene_hash(edited) != scene_hash(own)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('file = "none.stl"', 'geometry.file: "none.stl" cannot be read'),
        ("file = 3", "geometry.file: must be the name of a file, not 3"),
        ("inlet = 3", "geometry.inlet: must be a string or a table of sphere, box, plane, hole"),
        ("inlet = { sphere = [1.0] }", "geometry.inlet.sphere: needs 4 numbers, not 1"),
        ("inlet = { box = [[1.0, 2.0, 3.0]] }", "geometry.inlet.box: needs 2 corners, not 1"),
        ("inlet = { ball = [1.0] }", "geometry.inlet.ball: unknown key"),
        ("inlet = {}", "geometry.inlet: a region is one of sphere, box, plane, hole, not none"),
        ("folds = [{ at = -1.0 }]", "geometry.folds[0].at: -1.0 must be above 0"),
        ("folds = [{ at = 1.0 }]", "geometry.folds[0].side: is needed"),
        ("inlet = { sphere = [1e12, 0.0, 0.0, 1.0] }", "geometry.inlet.sphere: [1000000000000.0, "),
        ("folds = [3]", "geometry.folds[0]: must be a table { at = ..., side"),
        ('unit = "mm"', "geometry.unit: 'mm' needs the length of [physical]"),
        ("along = [0.0, 0.0, 0.0]", "geometry.along: has no direction"),
        ('rest = "a"', "geometry.rest: must be a list of strings"),
    ],
)
def test_tables_of_a_mesh_are_checked(tmp_path, line, message):
    (tmp_path / "bag.stl").write_bytes(b"")
    text = MESH.replace('file = "bag.stl"\n', "") if line.startswith("file") else MESH
    with pytest.raises(SceneError) as caught:
        loader.read(_file(tmp_path, f"{text}{line}\n"))
    assert any(error.startswith(message) for error in caught.value.errors), caught.value.errors


def test_a_mesh_needs_its_file(tmp_path):
    with pytest.raises(SceneError, match=r"geometry\.file: is needed"):
        loader.read(_file(tmp_path, MESH.replace('file = "bag.stl"\n', "")))


def test_a_mesh_is_no_scene(tmp_path):
    with pytest.raises(SceneError, match=r'a mesh is no scene; .* file = "Bag\.STL" and its inlet'):
        loader.read(tmp_path / "Bag.STL")
