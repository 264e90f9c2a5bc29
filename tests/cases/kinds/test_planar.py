"""Planar scenes: geometry, coarse coupled runs, named ends, refusals, resume."""

import numpy as np
import pytest
from rich.console import Console

from cases import loader
from cases.benchmarks.planar import load as planar_load
from cases.benchmarks.planar import models as planar_models
from cases.benchmarks.planar import runs as bench
from cases.kinds import simulation
from cases.kinds.planar import build
from cases.kinds.planar.config import ArcCurve, FlatCurve, FoldCurve, PlanarMesh
from cases.kinds.planar.geometry import pieces, planar_bag
from cases.output.history import read_history
from cases.runs.pictures import animate, draw
from cases.runs.start import resume, start
from coupling import Result
from hbem.planar.polygon import crossing

SCENES = [name for name in loader.shipped() if name.startswith("planar-")]
COARSE = ("mesh.straight=1", "mesh.curved=0.4", "time.dt=8")


@pytest.mark.parametrize("name", SCENES)
def test_shipped_scenes_build(name):
    scene = loader.read(name)
    c = build.bag(scene).coefficients
    assert simulation(scene).collision.inspect(c, c) is None


def test_pancake_area():
    """``2 w r - r^2 + pi r^2 / 2`` [T 4.3.1]."""
    g = FlatCurve(width=20.0)
    body = planar_bag(g, PlanarMesh(straight=1.0, curved=0.1))
    r = g.radius
    exact = 2 * g.width * r - r * r + 0.5 * np.pi * r * r
    scene = loader.read("planar-stokes-pancake")
    assert abs(build.structure(scene, body).volume(body.coefficients) / exact - 1.0) < 1e-6


@pytest.mark.parametrize("shape", [FlatCurve, ArcCurve, FoldCurve])
def test_membranes_close_over_the_inlet(shape):
    g = shape(inlet=0.3)
    curve = pieces(g)
    (start, end), tangents = curve.at(np.array([0.0, curve.length]))
    assert np.allclose(end, start * [-1, 1], atol=1e-12)
    assert np.allclose(tangents[0], tangents[1] * [1, -1], atol=1e-12)
    body = planar_bag(g, PlanarMesh(straight=0.5, curved=0.2))
    assert crossing(np.concatenate([body.coefficients[::2], body.inlet])) is None


def test_fold_is_as_flat_as_asked():
    x = pieces(FoldCurve())
    points, _ = x.at(np.linspace(0.0, x.length, 4000))
    width, depth = np.ptp(points, axis=0)
    assert abs(width / depth - 9.5) < 0.1


def test_stokes_pancake_bulges_first():
    run = bench.simulate("planar-stokes-pancake", *COARSE, "time.end=400")
    assert run.outcome.result is Result.COMPLETED
    assert run.outcome.counts["rejected"] == 0
    assert bench.volume_error(run) < 1e-10
    h = run.history
    assert np.abs(h.column("zeta")).max() < 1e-8
    assert np.abs(h.column("energy_defect")).max() < 1e-12
    assert h.column("top")[-1] > 5 * h.column("top")[0]  # the arms are still flat: local bulging


def test_uniform_pressure_opens_the_ends_first():
    """Without lubrication the ends open, the middle closes and its walls meet at V/V0 = 1.04."""
    stokes = bench.simulate("planar-stokes-pancake", *COARSE, "time.end=240")
    uniform = bench.simulate(
        "planar-stokes-pancake", *COARSE, planar_models.UNIFORM, "time.end=400", "time.dt_floor=0.5"
    )
    assert uniform.outcome.result is Result.SELF_INTERSECTION
    assert planar_models.shares(stokes, 1.03)[0] > 0.5  # new volume in the middle half
    assert planar_models.shares(uniform, 1.03)[0] < 0.0
    assert planar_models.height(stokes, 1.03) > 1.1 * planar_models.height(uniform, 1.03)
    with pytest.raises(ValueError, match="ends at"):
        planar_models.at_volume(uniform, 1.4)


def test_sections_add_up():
    run = bench.simulate("planar-stokes-fold", planar_models.UNIFORM, "time.end=25")
    points = run.states[0].coefficients[::2]
    parts = planar_models.sections(points, planar_models.stations(run))
    assert parts.min() > 0.0
    assert abs(parts.sum() / planar_models.area(points) - 1.0) < 1e-12
    assert np.ptp(parts[1:]) < 0.15 * parts[1]  # two folds of nearly the same length


def test_self_intersection_is_named():
    """A bag emptied without its exterior folds over itself or its inlet; the run says so."""
    run = bench.simulate(
        "planar-stokes-deflation",
        *("mesh.uniform=24", "fluid.viscosity_ratio=0", "structure.ends=hinged"),
        *("time.dt=20", "time.dt_floor=1"),
    )
    assert run.outcome.result in (Result.SELF_INTERSECTION, Result.INLET_CONTACT)
    assert run.history.column("min_gap").min() > 0.0


def test_potential_pancake():
    run = bench.simulate("planar-potential-pancake", "time.end=3")
    assert run.outcome.result is Result.COMPLETED
    assert run.outcome.counts["rejected"] == 0


def test_load_functional_converges_with_rate_two():
    errors, pressures = [], []
    p, reference = planar_load.load_functional(256, 1)
    for n in (32, 64):
        found, load = planar_load.load_functional(n, 1)
        errors.append(abs(load - reference))
        pressures.append(np.linalg.norm(found - p))
    assert np.log2(errors[0] / errors[1]) > 1.8  # measured 1.88
    assert 0.8 < np.log2(pressures[0] / pressures[1]) < 1.4  # measured 1.1
    assert abs(planar_load.load_functional(64, 2)[1]) < 1e-8 * abs(reference)  # parity


def test_impossible_combinations_are_named():
    with pytest.raises(loader.SceneError, match="quadratic"):
        loader.read("planar-potential-pancake", ["coupling.scheme=implicit"])
    with pytest.raises(loader.SceneError, match="lower sheet"):
        loader.read("planar-stokes-pancake", ["geometry.width=1"])
    with pytest.raises(loader.SceneError, match="even"):
        loader.read("planar-stokes-pancake", ["mesh.inlet=3"])


def test_resume_repeats_the_arithmetic(tmp_path):
    console = Console(quiet=True)
    long = [*COARSE, "time.end=64", "output.checkpoint_every=3", "output.picture=false"]
    short = [x if "end" not in x else "time.end=40" for x in long]
    start(loader.read("planar-stokes-pancake", long), tmp_path / "a", console)
    start(loader.read("planar-stokes-pancake", short), tmp_path / "b", console)
    text = (tmp_path / "b" / "run.toml").read_text().replace("end = 40.0", "end = 64.0")
    (tmp_path / "b" / "run.toml").write_text(text)
    resume(tmp_path / "b", console)
    a, b = (read_history(tmp_path / k / "history.csv") for k in "ab")
    for name in ("t", "volume", "pressure", "top", "min_gap", "zeta"):
        assert np.array_equal(a[name], b[name]), name


def test_report_draws_and_animates(tmp_path):
    scene = loader.read("planar-stokes-pancake", [*COARSE, "time.end=48"])
    finished = start(scene, tmp_path / "a", Console(quiet=True))
    assert finished.picture.stat().st_size > 10_000
    draw(tmp_path / "a")
    animate(tmp_path / "a")
    assert (tmp_path / "a" / "animation.gif").stat().st_size > 10_000
