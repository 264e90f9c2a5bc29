"""Thin cloth in scenes: it runs to the end, says what it is, starts without compression."""

import numpy as np
import pytest

from cases import loader
from cases.benchmarks.pancake.suite import simulate
from cases.benchmarks.shells.cloth import CENTRE, airbag, balloon, sheared
from cases.geometry.folding import accordion_folding, flat
from cases.geometry.inspection import strain_energy
from cases.geometry.pillows.folded import folded_bag
from cases.geometry.pillows.pillow import square
from cases.kinds import simulation
from cases.kinds.inflation import build
from cases.kinds.inflation.cloth import capacity
from cases.kinds.inflation.forecast import forecast
from coupling import Result, State
from shells.surfaces.pillow import Pillow

CLOTH = ["structure.law=tension-field", "structure.flexural_rigidity=1e-7", "fluid.model=pressure"]
COARSE = ["mesh.around=16", "time.dt=6", "output.fields_every=0", "output.picture=false"]


def test_mylar_balloon():
    (volume, diameter, height), found = balloon(24, "reduced")
    assert abs(volume) < 4e-3
    assert max(abs(diameter), abs(height)) < 7e-3
    assert found.zones[1] > 0.5


def test_square_airbag():
    centre, found = airbag(24)
    assert centre == pytest.approx(CENTRE, abs=2e-3)
    assert found.zones[1] > 0.5


def test_strip():
    force, exact = sheared(0.5)
    assert force == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize("seam", ["hinged", pytest.param("continuous", marks=pytest.mark.slow)])
def test_a_pillow_of_rigidity_1e_7_completes(seam):
    found = simulation(loader.read("pillow", [*CLOTH, *COARSE, f"structure.seam={seam}"])).run()
    assert found.result is Result.COMPLETED
    assert found.counts["rejected"] <= 2


def test_a_pancake_without_rigidity_completes_and_wrinkles():
    keys = {"mesh.degree": 2, "mesh.around": 8, "mesh.rim": 6, "mesh.fillet": 3, "time.dt": 32}
    coarse = [f"{k}={v}" for k, v in keys.items()] + COARSE[2:]
    zero = ["structure.flexural_rigidity=0", "structure.compression_share=1e-2"]
    run = simulate("pancake-pressure", [CLOTH[0], *zero, *coarse])
    assert run.outcome.result is Result.COMPLETED
    grid = build.simulated(run.scene).sampler.surface_grid(run.end.coefficients)
    state = grid["cell_data"]["wrinkling"]
    assert state.size == len(grid["quads"])
    assert {0, 1} <= set(state)


def test_hinged_seam_is_the_rim_of_the_flat_bag():
    surface = Pillow(24, 12)
    bag = folded_bag(surface, flat(0.02), plan="square")
    middle = np.array([0.5])
    x, y, z = (bag.membrane.sample(middle, middle) @ bag.flat[: bag.n_membrane]).T
    rim = np.maximum(abs(2.0 * x - 1.0), abs(2.0 * y))
    assert rim[bag.membrane.seam].min() > rim[~bag.membrane.seam].max()
    assert abs(z[bag.membrane.seam]).max() < abs(z[~bag.membrane.seam]).min()


def test_hinged_seam_carries_no_bending():
    scenes = [
        loader.read("pillow", [*CLOTH, f"structure.seam={s}"]) for s in ("continuous", "hinged")
    ]
    bag = folded_bag(Pillow(24, 12), flat(0.03))
    c = bag.coefficients
    open_ = State(0.0, c + 0.1 * c**2, np.zeros_like(c))
    stiff, free = (build.structure(scene, bag).energies(open_) for scene in scenes)
    assert free["membrane"] == stiff["membrane"]
    assert free["bending"] < 0.1 * stiff["bending"]


def test_square_plan_is_exact():
    s, t = np.meshgrid([0.0, 0.1, 0.25, 0.4, 0.7], [0.0, 0.2, 0.5, 0.9, 1.0])
    from cases.geometry.pillows.pillow import sphere_points

    a, b = -np.cos(np.pi * t).ravel(), np.cos(2.0 * np.pi * s).ravel()
    points = square(sphere_points(s, t).reshape(-1, 3))
    assert points[:, 0] == pytest.approx(0.5 + 0.5 * a, abs=1e-8)
    assert points[:, 1] == pytest.approx(0.5 * b, abs=1e-8)
    bag = folded_bag(Pillow(32, 16), flat(0.01), plan="square")
    assert bag.fit_error == pytest.approx(6.9e-3, rel=0.02)


def test_flat_reference_starts_without_compressive_stress():
    bag = folded_bag(Pillow(32, 16), accordion_folding(2, 6.0, 0.4))
    flat_cloth = [*CLOTH, "structure.reference=flat"]
    scene = loader.read("accordion-2-coarse", [*flat_cloth, "structure.compression_share=0"])
    shell = build.structure(scene, bag)
    start = State(0.0, bag.coefficients, np.zeros_like(bag.coefficients))
    energy = shell.energies(start)["membrane"]
    assert strain_energy(bag, 0.0, 0.0) == pytest.approx(energy, rel=1e-12)
    assert energy < 0.6 * strain_energy(bag)
    relaxed = build.relaxed(shell, start)
    assert shell.energies(relaxed)["membrane"] < 0.05 * energy  # 0.4 of it with 'svk'
    (item,) = [i for i in forecast(scene).items if i.name == "initial membrane energy"]
    assert "tension only" in item.note


def test_flat_bag_with_flat_reference_is_not_relaxed(monkeypatch):
    monkeypatch.setattr(build, "relaxed", None)  # would fail if called
    scene = loader.read("pillow", [*CLOTH, "mesh.around=16", "structure.reference=flat"])
    assert build.simulated(scene).initial.t == 0.0


def test_check_tells_what_resists_besides_cloth():
    def told(*keys):
        found = forecast(loader.read("pillow", [*CLOTH, *keys]))
        return {i.name: i.value for i in found.items}, " ".join(found.warnings)

    items, words = told()
    assert items["volume it can hold"] == pytest.approx(0.18, rel=0.03)
    assert "structure.seam = 'hinged'" in words
    assert "stiff hinge" not in told("structure.seam=hinged")[1]
    full = ("structure.seam=hinged", "inflow.final_volume=7.5")
    assert (
        "compression_share = 0.05 is not small"
        in told(*full, "structure.compression_share=0.05")[1]
    )
    assert "compression_share" not in told(*full, "structure.compression_share=1e-4")[1]
    assert "takes about" in told("inflow.final_volume=7.5", "structure.flexural_rigidity=1e-4")[1]


def test_capacity_of_discs_is_the_mylar_balloon():
    scene = loader.read("pillow", ["geometry.plan=round"])
    assert capacity(scene, 0.25 * np.pi) == pytest.approx(0.1523, abs=1e-4)
