"""A slice through the flow about a translating sphere."""

import numpy as np
import pytest

from cases.geometry.bodies import sphere
from cases.output.flow_slice import Slice, slice_picture
from hbem.flows.field import flow_field
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample


def test_slice(tmp_path):
    body = sphere(6, 6)
    surface = sample(body, body.coefficients, QuadratureOrders())
    tau = np.tile([0.0, 0.0, 1.5], (surface.patches.n_dofs, 1))
    where = Slice("y", 0.0, (-2.0, 2.0, -1.5, 1.5), n=24)
    _, _, points = where.grid()
    assert points.shape == (18, 24, 3)
    flow = flow_field(surface, tau, points.reshape(-1, 3))
    inside = np.linalg.norm(points.reshape(-1, 3), axis=1) < 1.0
    assert np.array_equal(flow.inside, inside)
    assert flow.velocity[inside] == pytest.approx(
        np.tile([0.0, 0.0, 1.0], (inside.sum(), 1)), abs=1e-3
    )
    path = slice_picture(lambda x: flow_field(surface, tau, x), where, tmp_path / "flow.png")
    assert path.stat().st_size > 10_000


def test_wrong_slice_is_named():
    with pytest.raises(ValueError, match="normal must be x, y or z"):
        Slice("w", 0.0, (0.0, 1.0, 0.0, 1.0))
