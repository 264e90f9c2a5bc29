"""What cannot be solved is refused in one message: crossing bodies, nesting, complex data, flux."""

from dataclasses import replace

import numpy as np
import pytest

from cases.geometry.bodies import sphere, torus
from hbem.flows.field import flow_field
from hbem.flows.stokes_flow import StokesFlow
from hbem.near.crossing import Arrangement, arrangement
from hbem.solvers.gmres import KrylovResult
from hbem.surfaces.patches import BezierPatches, union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample
from hbem.surfaces.topology import SurfaceError, closed_components

OBLIQUE = np.array([0.6, 0.64, 0.48])
BALL = sphere(6, 6)


def moved(body: BezierPatches, shift: np.ndarray, size: float = 1.0) -> BezierPatches:
    return replace(body, coefficients=size * body.coefficients + shift)


def arranged(*bodies: BezierPatches) -> Arrangement:
    body = union(*bodies)
    components = closed_components(body, body.coefficients)
    surface = sample(body, body.coefficients, QuadratureOrders())
    return arrangement(surface, components[body.dofs[body.indptr[:-1]]])


@pytest.mark.parametrize(
    "other",
    [
        moved(BALL, np.array([0.5, 0.3, 1.2])),
        moved(BALL, (2.0 - 1e-4) * OBLIQUE),
        moved(BALL, np.array([0.0, 0.0, 2.0])),
        moved(BALL, OBLIQUE, 0.01),
        moved(BALL, 0.51 * OBLIQUE, 0.5),
    ],
    ids=["overlap", "barely", "touch", "small across the wall", "half inside"],
)
def test_crossing_bodies(other):
    found = arranged(BALL, other)
    assert found.crossing is not None
    assert np.linalg.norm(found.crossing[2]) == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(SurfaceError, match="bodies 0 and 1 cross or touch at"):
        StokesFlow(union(BALL, other))


@pytest.mark.parametrize(
    ("bodies", "depth"),
    [
        ((BALL, moved(BALL, (2.0 + 1e-5) * OBLIQUE)), [0, 0]),
        ((BALL, moved(BALL, 0.0, 0.999)), [0, 1]),
        ((BALL, moved(BALL, 0.985 * OBLIQUE, 0.01)), [0, 1]),
        ((moved(BALL, 0.0, 0.2), BALL, moved(BALL, 0.0, 0.5)), [2, 0, 1]),
        ((torus(10, 10), BALL), [0, 0]),
    ],
    ids=["gap 1e-5", "shell .999", "close to the wall", "three", "in a hole"],
)
def test_bodies_that_do_not_cross(bodies, depth):
    found = arranged(*bodies)
    assert found.crossing is None
    np.testing.assert_array_equal(found.depth, depth)


def test_boxes_apart_are_not_looked_at():
    assert arranged(BALL, moved(BALL, np.array([0.0, 0.0, 3.0]))).tested == 0


@pytest.mark.parametrize("ratio", [0.0, 0.5, 1.5])
def test_field_in_the_core_of_nested_spheres(ratio, caplog):
    """All fluid within the outer sphere moves with both."""
    flow = StokesFlow(union(BALL, moved(BALL, 0.0, 0.5)), viscosity_ratio=ratio, measure="none")
    assert "body 1 lies inside body 0" in caplog.text
    inside = np.array([[0.0, 0.0, 0.2], [0.0, 0.7, 0.0], [0.1, 0.2, 0.3]])
    found = flow.traction([0.0, 0.0, 1.0]).field(inside)
    np.testing.assert_allclose(found.velocity, [[0.0, 0.0, 1.0]] * 3, atol=5e-5)
    np.testing.assert_array_equal(np.rint(found.angle), [2, 1, 2])


def test_a_ratio_that_leaves_no_viscosity_in_the_core_is_refused():
    with pytest.raises(SurfaceError, match=r"body 1 lies inside body 0.*a ratio below 2"):
        StokesFlow(union(BALL, moved(BALL, 0.0, 0.5)), viscosity_ratio=2.0)


def test_data_that_are_no_numbers():
    flow = StokesFlow(BALL, measure="none")
    for velocity in (np.array([0.0, 0.0, 1j]), lambda x: 1j * x):
        with pytest.raises(ValueError, match="velocity: complex"):
            flow.traction(velocity)
    for velocity in ([0.0, np.nan, 1.0], lambda x: np.inf * x):
        with pytest.raises(ValueError, match="velocity are not finite"):
            flow.traction(velocity)
    for bad in ({"viscosity": np.inf}, {"viscosity": np.nan}, {"viscosity_ratio": np.inf}):
        with pytest.raises(ValueError, match="must be a finite real number"):
            StokesFlow(BALL, **bad)
    with pytest.raises(ValueError, match="viscosity must be positive"):
        StokesFlow(BALL, viscosity=0.0)
    with pytest.raises(ValueError, match="coefficients: complex"):
        StokesFlow(BALL, 1j * BALL.coefficients)
    with pytest.raises(ValueError, match="points: complex"):
        flow_field(flow.surface, np.zeros((BALL.n_dofs, 3)), np.array([[0.0, 0.0, 1j]]))
    with pytest.raises(ValueError, match="background are not finite"):
        StokesFlow(BALL, background=lambda x: np.nan * x).traction([0.0, 0.0, 1.0])


def test_net_flux_has_a_result_of_its_own(caplog):
    flow = StokesFlow(union(BALL, moved(BALL, np.array([0.0, 0.0, 4.0]))))
    fine = flow.traction([0.0, 0.0, 1.0])
    assert fine.result is KrylovResult.DIRECT
    assert np.abs(fine.leak()).max() < 1e-6
    swelling = flow.traction(lambda x: (x - [0.0, 0.0, 4.0]) * (x[:, 2:] > 2.0))
    assert swelling.result is KrylovResult.NET_FLUX
    assert not swelling.result.ok
    np.testing.assert_allclose(swelling.flux(), [0.0, 4.0 * np.pi], atol=1e-4)
    np.testing.assert_allclose(swelling.leak(), [0.0, 1.0], atol=1e-5)
    assert "component 1: the boundary velocity has a net flux" in caplog.text
