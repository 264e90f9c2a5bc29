"""A capsule in planar strain against small-deformation theory; fluid, drive and scene keys."""

import numpy as np
import pytest

from cases import loader
from cases.benchmarks.recorded import RecordedHistory
from cases.kinds import simulation
from cases.kinds.capsule import build

COARSE = ["mesh.rows=6", "mesh.around=8"]


def deformed(*options):
    history = RecordedHistory()
    scene = loader.read("capsule", [*COARSE, *options])
    outcome = simulation(scene, [history]).run()
    assert outcome.result.ok
    return scene, history


def test_steady_deformation_does_not_depend_on_the_viscosity_ratio():
    """rows = 6 is 1.2% off theory (8: 0.3%, 12: 0.1%); the ratio must not matter."""
    found = []
    for ratio in (0.3, 3.0):
        step = 40.0 * (1.0 + ratio)  # four relaxation times
        scene, history = deformed(
            f"fluid.viscosity_ratio={ratio}", f"time.dt={step}", f"time.end={4 * step}"
        )
        found.append(history.rows[-1]["deformation"])
        assert found[-1] == pytest.approx(scene.exact_deformation, rel=0.015)
        volume = history.column("volume")
        assert np.ptp(volume) < 1e-11 * volume[0]
    assert found[0] == pytest.approx(found[1], rel=5e-4)


def test_every_scheme_carries_the_background():
    """Aitken at a small step follows the implicit run to the coupling tolerance."""
    short = ["fluid.mass_ratio=0.05", "time.dt=0.2", "time.end=1.0"]
    _, implicit = deformed(*short)
    _, aitken = deformed(*short, "coupling.scheme=aitken")
    moved = implicit.rows[-1]["deformation"]
    assert moved > 1e-4
    assert aitken.rows[-1]["deformation"] == pytest.approx(moved, rel=2e-4)


@pytest.mark.parametrize("ratio", [0.3, 1.0])
def test_traction_is_drive_plus_response(ratio):
    scene = loader.read("capsule", [*COARSE, f"fluid.viscosity_ratio={ratio}"])
    body = build.capsule(scene)
    operator = build.fluid(scene, body).assemble(body.coefficients)
    velocity = 1e-3 * np.random.default_rng(0).standard_normal(body.coefficients.shape)
    load = operator.load(operator.traction(velocity))
    parts = operator.drive() + (operator.response() @ velocity.ravel()).reshape(-1, 3)
    assert parts == pytest.approx(load, abs=1e-12 * np.abs(load).max())
    dense = operator.response().dense() @ velocity.ravel()
    scale = np.abs(dense).max()
    assert operator.response() @ velocity.ravel() == pytest.approx(dense, abs=1e-9 * scale)


def test_no_force_in_its_own_strain():
    """A membrane that moves with the undisturbed flow disturbs nothing (equal viscosities)."""
    scene = loader.read("capsule", COARSE)
    body = build.capsule(scene)
    operator = build.fluid(scene, body).assemble(body.coefficients)
    strain = 0.5 * scene.strain_rate * np.array([1.0, -1.0, 0.0])
    load = operator.load(operator.traction(strain * body.coefficients))
    assert np.abs(load).max() < 1e-9 * np.abs(operator.drive()).max()


def test_bad_meshes_are_refused():
    with pytest.raises(loader.SceneError, match="multiple of 4"):
        loader.read("capsule", ["mesh.around=10"])
