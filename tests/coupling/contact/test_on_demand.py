"""Contact that is asked only where it can act: the same answers, and none while sheets are far."""

import numpy as np
import pytest
from scipy.sparse import identity

from coupling import BarrierContact, SampledMesh
from coupling.contact.on_demand import OnDemand
from coupling.contact.smallest_gap import minimum_gap

REACH = 0.1
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]])


def squares(gap):
    """Two unit squares that face each other."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return np.concatenate([corners, corners + np.array([0.0, 0.0, gap])])


@pytest.fixture
def contact():
    mesh = SampledMesh(identity(8, format="csr"), TRIANGLES, np.arange(4))
    inner = BarrierContact(mesh, mesh.areas(squares(1.0)), REACH, 2.0)
    return OnDemand(inner, lambda c: minimum_gap(c, TRIANGLES, 1.0), REACH)


def test_far_sheets_cost_one_measurement(contact):
    """Points may move by (1 - 0.1) / 2 before contact is possible: 0.8 is, 0.5 is not."""
    for gap in (1.0, 0.9, 0.8, 0.7, 0.6):
        assert contact.energy(squares(gap)) == 0.0
        assert contact.free_step(squares(gap), squares(1.0)) == 1.0
    gradient, tangent = contact.derivatives(squares(0.6))
    assert not gradient.any()
    assert tangent.nnz == 0
    assert contact.distance(squares(0.6)) == np.inf
    assert (contact.measured, contact.asked) == (1, 0)


def test_near_sheets_get_the_answers_of_contact(contact):
    for gap in (1.0, 0.5, 0.09, 0.05, 0.3, 0.02):
        c, inner = squares(gap), contact.contact
        assert contact.energy(c) == inner.energy(c)
        assert contact.distance(c) == inner.distance(c)
        assert contact.within_reach(c) == inner.within_reach(c)
        np.testing.assert_array_equal(contact.derivatives(c)[0], inner.derivatives(c)[0])
        np.testing.assert_array_equal(contact.pressure(c), inner.pressure(c))
        np.testing.assert_array_equal(contact.force(c), inner.force(c))
    assert contact.asked > 0


def test_a_jump_through_the_other_sheet_is_seen(contact):
    assert contact.free_step(squares(1.0), squares(-1.0)) < 0.5
    assert contact.near(squares(1.0), squares(-1.0))
