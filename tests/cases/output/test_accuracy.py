"""Accuracy of a run whose sheets touch: elements in contact count apart."""

from types import SimpleNamespace

import numpy as np
import pytest

from cases.geometry.bag_sampler import triangulated
from cases.geometry.folding import flat
from cases.geometry.pillows.folded import folded_bag
from cases.kinds.collision import touched_elements
from cases.output.accuracy import Accuracy
from hbem.accuracy import budget
from hbem.traction_error import TractionError
from shells.surfaces.pillow import Pillow

ASKED = 1e-2
SHARES = np.array([3e-3, 4e-3, 12e-3])  # 5e-3 on the first two elements, 13e-3 in all


def step(gap, contacts):
    error = TractionError(ASKED, 13e-3, 1e-4, 0.0, 0.0, elements=SHARES)

    def measure(krylov, quadrature, mesh):
        return error if mesh else TractionError(ASKED, np.nan, 1e-4, 0.0, krylov)

    traction = SimpleNamespace(zeta=0.1, residual=1e-9, measure=measure)
    row = {"min_gap": gap, "velocity_max": 1.0, "contacts": contacts}
    return SimpleNamespace(row=row, traction=traction, state=SimpleNamespace(coefficients=None))


def accuracy():
    touched = np.array([True, True, False])
    return Accuracy(budget(ASKED, 0.1, 1.0), 0.1, 1.0, touched=lambda c: touched)


def test_the_verdict_names_both_parts():
    run = accuracy()
    assert "in contact" not in run.note(step(0.1, 0))
    assert run.after()["elements_in_contact"] == 0
    said = run.note(step(0.04, 7))
    assert said.startswith("traction error missed")
    assert "of the mesh's share 5.0e-03 on 2 elements in contact, 1.2e-02 elsewhere" in said
    assert str(run.so_far()).endswith(
        "5.0e-03 on elements in contact (2 at most), 1.2e-02 elsewhere"
    )
    after = run.after()
    assert after["elements_in_contact"] == 2
    assert after["mesh_in_contact"] == pytest.approx(5e-3)
    assert after["mesh_elsewhere"] == pytest.approx(12e-3)
    assert after["verdict"] == "missed"


def test_resumed_runs_keep_both_parts():
    run, again = accuracy(), accuracy()
    run.note(step(0.04, 7))
    again.taken_up(run.after())
    assert again.after() == run.after()


def test_touched_elements_are_those_pressed_on():
    """Pressure on the samples above z = 0 presses on the upper sheet's elements and their rims."""
    bag = folded_bag(Pillow(16, 8), flat(0.05))
    mesh = triangulated(bag, 3)
    upper = (mesh.sample @ bag.coefficients)[:, 2] > 0.02
    contact = SimpleNamespace(mesh=mesh, pressure=lambda c: 1.0 * upper)
    touched = touched_elements(contact, 3)(bag.coefficients)
    elements = bag.membrane.n_elements + bag.inlet.n_elements
    assert touched.shape == (elements,)
    middle = np.array([0.5])
    z = (bag.membrane.sample(middle, middle) @ bag.coefficients[: bag.n_membrane])[:, 2]
    assert touched[: len(z)][z > 0.022].all()
    assert not touched[: len(z)][z < 0.0].any()
    assert not touched[len(z) :].any()  # the inlet is on the lower sheet
