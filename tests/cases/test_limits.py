"""Limits of scenes: ranges of all numbers, encodings, sizes before anything is built, dead keys."""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from typing import get_args, get_type_hints

import pytest

from cases import cli, loader
from cases.kinds import KINDS, sizes
from cases.kinds.inflation import plan
from cases.scene_file import last_resort
from cases.sections import Choice, SceneError, without_effect
from hbem.layers.choice import bytes_of

TWENTY = 20 * 2**30


def _file(tmp_path, data):
    path = tmp_path / "scene.toml"
    path.write_bytes(data)
    return path


def _tables():
    for kind in KINDS.values():
        for section in kind.sections.values():
            for table in section.tables.values() if isinstance(section, Choice) else [section]:
                yield table
                for hint in get_type_hints(table).values():
                    yield from (kind for kind in _leaves(hint) if is_dataclass(kind))


def _leaves(hint):
    """Types that a hint is made of."""
    inner = get_args(hint)
    return [leaf for part in inner for leaf in _leaves(part)] if inner else [hint]


def test_every_number_has_two_ends():
    open_ended = []
    for table in {*_tables()}:
        hints = get_type_hints(table)
        for f in fields(table):
            limits = f.metadata
            number = {int, float} & {*_leaves(hints[f.name])}
            ends = {*limits} & {"least", "above"}, {*limits} & {"most", "below"}
            if number and "choices" not in limits and not all(ends):
                open_ended.append(f"{table.__name__}.{f.name}")
    assert open_ended == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind = []", "kind: [] is none of 'inflation'"),
        ("[time]\ndt = 1e-306", "time.dt: 1e-306 must be at least 1e-09"),
        ("[time]\ndt = 1e-6\nend = 800", "time.dt: 1e-06 makes 8e+08 steps"),
        ("[time]\ndt = 1e400", "time.dt: must be finite, not inf"),
        ("[time]\ndt = " + "9" * 4000, "time.dt: must be finite, not a whole number of about 4000"),
        ("[time]\ndt = " + "9" * 5000, 'a number has too many digits; look at "dt"'),
        ("[fluid]\npolar = [25, 25]", "fluid.polar: [25, 25] must be at most 24"),
        ("[time]\nerror = 1e-320", "time.error: 1e-320 must be 0 or of a size between 1e-20"),
        ("[mesh]\nrim = " + "[" * 3000 + "]" * 3000, "is nested too deeply; look at"),
        ("[mesh]\nrim = { x = 1 }", "mesh.rim: must be a whole number, not a section"),
        ('name = "a/b"', 'name: "a/b" names no folder'),
        ('name = "' + "x" * 101 + '"', "name: has 101 characters; use 100 at most"),
        ("[geometry]\nradius = 1e-4\nhalf_width = 5e3", "geometry.radius: 0.0001 is below 1e-05"),
        (
            'kind = "planar"\n[fluid]\nmodel = "potential"\n[coupling]\nscheme = "auto"',
            "coupling.scheme: \"auto\" is none of 'iqn-ils', 'aitken', 'constant', 'gauss-seidel': "
            "the load of potential flow is quadratic",
        ),
    ],
)
def test_one_message_with_key_value_and_remedy(tmp_path, capsys, text, message):
    assert cli.main(["check", str(_file(tmp_path, text.encode()))]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert len(line) < 300


def test_byte_order_marks_pass_and_other_encodings_are_named(tmp_path):
    text = "[time]\ndt = 8\n"
    assert loader.read(_file(tmp_path, text.encode("utf-8-sig"))).time.dt == 8.0
    for encoding in ("utf-16", "utf-32"):
        with pytest.raises(SceneError, match=r"UTF-16; save it as UTF-8"):
            loader.read(_file(tmp_path, text.encode(encoding)))
    with pytest.raises(SceneError, match="is not UTF-8 text"):
        loader.read(_file(tmp_path, 'description = "é"'.encode("latin-1")))


def test_si_values_that_push_groups_out_of_range(tmp_path):
    text = "[physical]\nlength = 1e5\nthickness = 1e-6\nyoung_modulus = 1e9\n"
    text += "areal_density = 1.0\nviscosity = 1.0\n"
    with pytest.raises(SceneError, match=r"flexural_rigidity.*follows from physical.thickness"):
        loader.read(_file(tmp_path, text.encode()))


@pytest.mark.parametrize("name", ["pancake", "pancake-thesis", "pillow", "accordion-2-coarse"])
def test_counts_and_gaps_are_those_of_the_fitted_bag(name):
    keys = ["mesh.joints=double", "mesh.rim=5"] if name == "pancake" else []
    found = plan.InflationPlan(loader.read(name, keys))
    bag = found.bag
    assert found.elements == sum(part.n_elements for part in bag.parts)
    assert found.unknowns == 3 * sum(part.n_dofs for part in bag.parts)
    # where sheets may touch, films are as thin as contact leaves them: 0.4 of a reach of 0.15 gaps
    left = 0.06 if found.folded else 1.0
    assert found.budget.thinness == pytest.approx(left * bag.gap / (2.0 * bag.extent), rel=1e-12)


@pytest.mark.parametrize(
    ("scene", "keys", "remedy"),
    [
        ("accordion-8", ["mesh.around=3000"], "lower mesh.around"),
        ("pancake", ["geometry.half_width=1e4", "fluid.solver=lu"], "fluid.compression to 'auto'"),
        ("capsule", ["mesh.rows=1000", "mesh.around=1000"], "lower mesh.rows"),
        ("planar-stokes-fold", ["mesh.uniform=4096", "mesh.halvings=8"], "mesh.halvings"),
        ("slit-annulus", ["mesh.along=1024", "mesh.across=1024"], "lower mesh.along"),
        ("cavity-re10", ["flow.cells=160", "flow.refinements=14"], "lower flow.cells"),
    ],
)
def test_what_the_memory_cannot_hold_is_refused_unbuilt(monkeypatch, capsys, scene, keys, remedy):
    monkeypatch.setattr(sizes, "memory_bytes", lambda: TWENTY)
    monkeypatch.setattr(plan, "initial_bag", None)
    options = [part for key in keys for part in ("--set", key)]
    for command in ("check", "run"):
        assert cli.main([command, scene, *options]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert re.search(r"need about \d.*GB, .* this machine has 20 GB", line)
        assert remedy in line


def test_large_bags_are_forecast_without_their_geometry(monkeypatch):
    monkeypatch.setattr(plan, "initial_bag", None)
    found = KINDS["inflation"].forecast(
        loader.read("accordion-8", ["mesh.around=400", "mesh.across=200"])
    )
    named = {item.name: item for item in found.items}
    assert named["elements"].value == 80000
    assert named["compressed operator"].unit == "GB"
    assert "geometry was not measured" in found.warnings[0]


@pytest.mark.parametrize(
    ("method", "tolerance", "points", "measured"),
    [
        ("h2", 1e-3, (23328, 23328), 8.98),
        ("h2", 3.5e-5, (23328, 23328), 21.4),
        ("h2", 3.5e-5, (23328, 41472), 39.5),
        ("aca", 1e-3, (23328, 23328), 6.73),
        ("aca", 1e-5, (23328, 23328), 8.44),
    ],
)
def test_memory_of_compressed_operators(method, tolerance, points, measured):
    """Against operators of a disc bag of 2592 elements, in kB an unknown with the near field."""
    near = 1.52 if points[0] == points[1] else 2.32
    found = bytes_of(method, tolerance, 2592, *points) / 7776e3 + near
    assert found == pytest.approx(measured, rel=0.1)


def test_keys_without_effect_are_named(tmp_path):
    text = '[geometry]\nkind = "pillow"\nfolds = 4\n[fluid]\nmodel = "pressure"\ntolerance = 0.01\n'
    scene = loader.read(_file(tmp_path, text.encode()))
    expected = (
        'geometry.folds = 4 has no effect with geometry.fold = "flat"; leave it out',
        'fluid.tolerance = 0.01 has no effect with fluid.model = "pressure"; leave it out',
    )
    assert tuple(without_effect(scene)) == expected
    assert KINDS["inflation"].forecast(scene).warnings[-2:] == expected
    assert KINDS["inflation"].simulated(scene).skips[-2:] == expected
    for name in loader.shipped():
        assert without_effect(loader.read(name)) == []


def test_what_is_printed_is_what_is_meant(tmp_path, capsys):
    text = "[physical]\nlength = 0.3\nthickness = 3e-2\nyoung_modulus = 2.5e5\n"
    text += "areal_density = 0.25\nviscosity = 1.8e-2\n[fluid]\nviscosity_ratio = 0.5\n"
    assert cli.main(["check", str(_file(tmp_path, text.encode()))]) == 0
    printed = capsys.readouterr().out
    assert "from [physical]" in printed
    assert "equal viscosities" not in printed
    assert re.search(r"double layer\s+assembled\s+viscosity ratio 0.5", printed)


def test_the_last_resort_names_the_scene_and_its_oddest_number():
    scene = loader.read("pancake", ["mesh.around=96", "time.dt=4"])
    expected = r"pancake: too big; look at mesh.around = 96 \(default 12\)"
    with pytest.raises(SceneError, match=expected), last_resort(scene.name, scene):
        raise OverflowError("too big")
