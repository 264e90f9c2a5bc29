"""The coupled pancake on the reduced mesh of continuous integration."""

import numpy as np
import pytest

from cases import loader
from cases.benchmarks.coupling.schemes import kept_row
from cases.benchmarks.pancake.suite import FAST, asymmetry, profile, simulate, static_pressure
from cases.kinds.inflation import build
from cases.kinds.inflation.forecast import forecast, volume
from cases.kinds.inflation.initial_bag import initial_bag
from cases.kinds.inflation.plan import InflationPlan
from cases.kinds.inflow import ramp_integral
from coupling import Result, State
from coupling.schemes.contraction import measure_contraction
from shells.equilibrium.load_paths import static_path


@pytest.fixture(scope="module")
def run():
    return simulate("pancake", [*FAST, "time.end=160"])


def test_run_completes_without_rejection(run):
    assert run.outcome.result is Result.COMPLETED
    assert run.outcome.counts["rejected"] == 0
    assert run.per_step("assemblies") <= 5.0  # the first steps need most; 3.0 over the whole run


def test_volume_flux_and_gap(run):
    h = run.history
    assert np.abs(h.column("volume") / h.column("volume_prescribed") - 1.0).max() < 1e-10
    # 2x2 outer points and p = 2: quadrature error of the constraint, well below the data
    assert (np.abs(h.column("zeta")[1:]) / h.column("velocity_max")[1:]).max() < 1e-4
    # sheets that face each other within 26 degrees, at the rim: no closer than at the start
    assert h.column("min_gap").min() >= h.column("min_gap")[0] > 1.84
    assert np.abs(h.column("flux_ratio")[1:] - 1.0).max() < 0.1


def test_nothing_symmetrises_but_symmetry_holds(run):
    R = run.scene.geometry.half_width
    assert max(asymmetry(run.body, s.coefficients) for s in run.history.states) < 1e-8 * R


def test_energy_balance_closes(run):
    h = run.history
    scale = np.abs(h.column("pressure_work")).max()
    assert np.abs(h.column("energy_defect")).max() < 1e-9 * scale


def test_it_bulges_over_the_inlet_first(run):
    """The flow lifts the top while the rim still stands; uniform pressure does not."""
    uniform = simulate("pancake-pressure", [*FAST[:3], "time.end=160"])
    tops = [profile(r.body, r.end.coefficients)[0] for r in (run, uniform)]
    assert run.history.rows[-1]["volume"] == pytest.approx(uniform.history.rows[-1]["volume"])
    assert tops[0] > 1.08 * tops[1]


def test_response_equals_load_of_traction(run):
    scene = run.scene
    fluid = build.fluid(InflationPlan(scene))
    operator = fluid.assemble(run.end.coefficients)
    v = run.end.velocity
    by_traction = operator.load(operator.traction(v)).ravel()
    for response in (operator.response() @ v.ravel(), operator.response().dense() @ v.ravel()):
        assert np.abs(response - by_traction).max() < 1e-10 * np.abs(by_traction).max()


def test_contraction_measured_and_forecast():
    """Formula 0.49 against 0.48 measured at dt = 1 (half width 10)."""
    scene = loader.read("pancake", ["mesh.degree=2", "mesh.around=8"])
    plan = InflationPlan(scene)
    body = plan.bag
    structure, fluid = build.structure(scene, body), build.fluid(plan)
    state = State(0.0, body.coefficients, np.zeros_like(body.coefficients))
    inverse = structure.linearised(state, 1.0)
    rho = measure_contraction(fluid.assemble(body.coefficients).response(), inverse, 1.0)
    assert rho == pytest.approx(0.48, rel=0.05)


def test_schemes_agree():
    common = ["mesh.degree=2", "mesh.around=8", "fluid.outer_points=2", "time.dt=2", "time.end=12"]
    implicit, aitken = (
        simulate("pancake", [*common, f"coupling.scheme={s}"]) for s in ("implicit", "aitken")
    )
    moved = implicit.end.coefficients - implicit.history.states[0].coefficients
    difference = aitken.end.coefficients - implicit.end.coefficients
    assert np.linalg.norm(difference) < 1e-3 * np.linalg.norm(moved)


def test_static_pancake():
    """Half width 20, fourfold volume, rigidity 1e-2: p = 1.33865e-3 converged, 24 rows 0.7%."""
    keys = {"mesh.degree": 2, "mesh.rim": 6, "mesh.fillet": 3, "structure.flexural_rigidity": 1e-2}
    scene = loader.read("pancake-20", [f"{k}={v}" for k, v in keys.items()])
    body = initial_bag(scene)
    structure = build.structure(scene, body)
    start = structure.volume(body.coefficients)
    assert start == pytest.approx(volume(body), rel=1e-12)
    assert body.membrane.s.n_elements == 24
    end = static_path(structure, body.coefficients, start * np.linspace(1.0, 4.0, 31)[1:])
    assert end.ok
    assert end.state.pressure == pytest.approx(1.33865e-3, rel=7e-3)


def test_final_pressure_of_the_uniform_model_is_static():
    run = simulate("pancake-pressure", FAST[:3])
    assert run.end.pressure == pytest.approx(static_pressure(run), rel=5e-3)


def test_influx_integrates_to_one():
    assert ramp_integral(0.0, 1.0, 2.0) == 0.0
    assert ramp_integral(3.0, 1.0, 2.0) == pytest.approx(1.0, abs=1e-15)
    assert ramp_integral(9.0, 1.0, 2.0) == pytest.approx(1.0, abs=1e-15)
    t = np.linspace(0.0, 3.0, 3001)
    rate = np.gradient([ramp_integral(x, 1.0, 2.0) for x in t], t)
    assert rate[1500] == pytest.approx(0.5)  # constant influx 1/t2
    assert np.abs(np.diff(rate)).max() < 2e-3  # continuous


def test_volume_of_the_exact_pancake():
    """Closed form at r = 1; [T footnote 6.v] prints 104/3 where this body has 48."""
    w = 40.0
    polynomial = 3 * w**2 - 12 * w + 3 * np.pi * w - 12 * np.pi + 48.0
    body = initial_bag(loader.read("pancake-20"))
    assert body.exact_volume == pytest.approx(np.pi / 6.0 * polynomial, rel=1e-12)
    assert volume(body) == pytest.approx(body.exact_volume, rel=1e-4)


def test_check_warns_of_divergence():
    calm = forecast(loader.read("pancake"))
    assert not calm.warnings
    rho = next(i.value for i in calm.items if i.name == "contraction rho")
    assert rho == pytest.approx(16 * 0.4925, rel=1e-3)
    warned = forecast(loader.read("pancake", ["coupling.scheme=gauss-seidel"]))
    assert any("diverges" in w and "time.dt below" in w for w in warned.warnings)


def test_a_slow_run_keeps_operators():
    """At dt = 1 the first steps hardly move: fewer assemblies, the same end within tolerance."""
    row = kept_row(1.0, 4)
    assert row["kept"] > 0
    assert row["assemblies"] + row["kept"] <= row["of"] + 2
    assert row["assemblies"] < row["of"]
    assert row["error"] < 1e-3  # the scene's tolerance of tractions; measured 3.7e-6
