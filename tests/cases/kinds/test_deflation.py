"""Bags that are emptied end in a named result before their sheets cross.

The witness is independent of the test in the run: the section of the smooth bag with a vertical
plane through its axis, 24 points an element, two of whose segments cross or not.
"""

import numpy as np
import pytest

from cases import loader
from cases.benchmarks.recorded import RecordedHistory
from cases.geometry.bag_sampler import triangulated
from cases.kinds import simulation
from cases.kinds.inflation.plan import InflationPlan
from coupling import Result

REDUCED = ("mesh.degree=2", "mesh.around=8", "time.dt=32", "fluid.outer_points=2")
EMPTIED = (*REDUCED, "inflow.final_volume=0.02")
UNCARRIED = (*EMPTIED, "contact.force=none")
PER_ELEMENT = np.linspace(0.0, 1.0, 24)


class Notes(RecordedHistory):
    """A history that keeps the log's lines, too."""

    def __init__(self):
        super().__init__()
        self.notes = []

    def on_note(self, step, text):
        self.notes.append((step, text))


def emptied(name, *options, steps=None):
    """Bag, history and outcome of a run."""
    scene, history = loader.read(name, [*UNCARRIED, *options]), Notes()
    return InflationPlan(scene).bag, history, simulation(scene, [history]).run(steps=steps)


def crossed(body, history):
    """Whether the section of each accepted state crosses itself."""
    return [crosses(section(body, state.coefficients)) for state in history.states]


def section(body, coefficients):
    """Polyline (n, 2) of radius and height from the top's pole to the rim of the inlet."""
    one = np.zeros_like(PER_ELEMENT)
    lines = body.membrane.sample(PER_ELEMENT, one) @ coefficients[: body.n_membrane]
    lines = lines.reshape(-1, PER_ELEMENT.size, 3)
    in_plane = (abs(lines[:, :, 1]).max(axis=1) < 1e-6) & (lines[:, -1, 0] > 0.0)
    assert in_plane.sum() == body.membrane.n_elements / 8  # one element in eight around
    line = lines[in_plane][:, :, [0, 2]]
    # elements share their ends to rounding only: a segment between both would cross its neighbours
    return np.concatenate([*line[:, :-1], line[-1, -1:]])


def crosses(polyline):
    """Whether two segments that are not neighbours cross, by signs of areas, all pairs."""
    p, q = polyline[:-1], polyline[1:]

    def side(a, b, c):
        (u, v), (s, t) = (np.moveaxis(b - a, -1, 0), np.moveaxis(c - a, -1, 0))
        return np.sign(u * t - v * s)

    a, b, c, d = p[:, None], q[:, None], p[None], q[None]
    found = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    i, j = np.nonzero(found)
    return bool((abs(i - j) > 1).any())


def test_the_witness_sees_a_crossing():
    angle = np.linspace(0.0, 3.0 * np.pi, 50)
    spiral = (angle[:, None] + 1.0) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert not crosses(spiral)
    assert crosses(np.concatenate([spiral, [[0.5, 0.0]]]))


def test_untested_sheets_cross_in_silence():
    """What the test in the run is for: switched off, the bag is "emptied" to its end."""
    body, history, outcome = emptied(
        "pancake-pressure", "contact.test=off", "time.closing=0", "time.dt_floor=1"
    )
    assert outcome.result is Result.COMPLETED
    assert any(crossed(body, history))


def test_deflation_ends_before_sheets_cross():
    body, history, outcome = emptied("pancake-pressure", "time.dt_floor=1")
    assert outcome.result is Result.SELF_INTERSECTION
    assert not any(crossed(body, history))
    told = [(step, text) for step, text in history.notes if "self-intersection" in text]
    assert len(told) == 1
    step, text = told[0]
    assert step == 1
    assert "on since step 1, because the volume" in text
    row = history.rows[-1]
    assert 0.4 < row["volume"] / history.rows[0]["volume"] < 0.5  # measured 0.45
    assert 0.0 < row["min_gap"] < 0.02


def test_inflation_starts_without_the_test():
    """An unfolded bag that fills says what it skips, and needs no test while its sheets part."""
    options = [*REDUCED, "time.dt=4", "contact.force=none"]
    scene, history = loader.read("pancake-pressure", options), Notes()
    assert any("self-intersection: until the gap halves" in s for s in InflationPlan(scene).skips())
    run = simulation(scene, [history])
    assert run.run(steps=3).result is Result.STOPPED
    assert run.collision.counts["tests"] == 1  # of the initial bag
    assert not any("self-intersection" in text for _, text in history.notes)


@pytest.mark.slow
def test_contact_carries_the_sheets_of_an_emptied_bag():
    """Forces take it from 45% of the volume, where sheets meet, to less than 20% uncrossed."""
    scene, history = loader.read("pancake-pressure", [*EMPTIED, "time.dt_floor=1"]), Notes()
    body, run = InflationPlan(scene).bag, simulation(scene, [history])
    outcome = run.run()
    assert outcome.result in (Result.COMPLETED, Result.STEP_FLOOR)
    row = history.rows[-1]
    assert row["volume"] / history.rows[0]["volume"] < 0.2  # measured 0.15
    assert row["contacts"] > 100
    finer = triangulated(body, 6)
    assert not any(finer.intersects(state.coefficients) for state in history.states)


@pytest.mark.slow
def test_deflation_in_stokes_flow_ends_before_sheets_cross():
    """The flow draws the top into the neck, where it meets the fillet at 85% of the volume."""
    body, history, outcome = emptied("pancake")
    assert outcome.result is Result.SELF_INTERSECTION
    assert not any(crossed(body, history))
    row = history.rows[-1]
    assert row["volume"] / history.rows[0]["volume"] == pytest.approx(0.852, abs=0.005)
    body, history, _ = emptied("pancake", "contact.test=off", "time.closing=0", steps=12)
    assert any(crossed(body, history))
