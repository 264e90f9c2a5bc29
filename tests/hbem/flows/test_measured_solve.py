"""Solves that measure their own error: estimates against dense, finer-rule and finer-mesh truth."""

from dataclasses import replace

import numpy as np
import pytest

from cases.geometry.bodies import sphere, spheroid
from cases.geometry.pillows.pillow import round_bag
from hbem import StokesFlow
from hbem.flows.measured_solve import Measured, MeasuredSolve, left_by_rules
from hbem.solvers.refinement import remaining
from hbem.surfaces.patches import union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.traction_error import TractionError, Verdict

X = np.array([1.0, 0.0, 0.0])
Z = np.array([0.0, 0.0, 1.0])
FLOWS = {"squeeze": lambda x: x * [1.0, 1.0, -2.0], "slide": lambda x: np.tile(X, (len(x), 1))}
FINEST = QuadratureOrders(far=8, near_offset=18.0, near_slope=5.0, radial=24, angular=24)


@pytest.mark.parametrize("name", FLOWS)
@pytest.mark.parametrize("method", ["h2", "aca"])
def test_compression_is_measured_and_corrected(name, method):
    """Flows without lubrication pressure lose most: what rows of A x do not show."""
    bag = round_bag(20, gap=0.02)
    flow = StokesFlow(bag.patches(), compression=method, measure="operator")
    exact = StokesFlow(
        bag.patches(), orders=flow.orders, compression="dense", measure="none"
    ).traction(FLOWS[name])
    tested, _ = flow._tested(FLOWS[name](flow.points))
    size, exact = flow.solver.size, exact.coefficients.ravel()
    plain = flow.formulation.system.solve(flow.formulation.data(tested))
    measured = flow.solver.decompressed(plain, tested)
    before = size(plain.solution - exact) / size(exact)
    after = size(measured.solved.solution - exact) / size(exact)
    assert measured.compression[0] == pytest.approx(before, rel=0.3)
    assert before > 20.0 * after
    error = flow.solver.error(measured, 0.0)
    assert after <= error.compression + error.krylov <= flow.budget.traction


@pytest.mark.parametrize("name", FLOWS)
def test_quadrature_is_measured_and_corrected(name):
    body = spheroid(6, 5, c=0.2, grading=0.5)
    rough = QuadratureOrders(near_offset=4.0, near_slope=1.5, radial=6, angular=6)
    flow = StokesFlow(body, tolerance=1e-4, orders=rough, measure="operator")
    exact = StokesFlow(body, orders=FINEST, measure="none").traction(FLOWS[name])
    found = flow.traction(FLOWS[name])
    plain = StokesFlow(body, orders=rough, measure="none").traction(FLOWS[name])
    size, exact = flow.solver.size, exact.coefficients.ravel()
    before = size(plain.coefficients.ravel() - exact) / size(exact)
    after = size(found.coefficients.ravel() - exact) / size(exact)
    assert before > 3.0 * after
    assert after <= 1.5 * found.error.quadrature
    assert np.isnan(plain.error.quadrature)
    assert plain.error.verdict is Verdict.CANNOT_TELL


def test_the_mesh_s_share_is_its_error():
    """Against the exact traction of a sphere in shear."""

    def shear(x):
        return np.stack([x[:, 1], x[:, 0], 0.0 * x[:, 0]], axis=1)

    coarse, fine = (StokesFlow(sphere(n, n, degree=p), tolerance=1e-3) for n, p in ((6, 2), (8, 3)))
    found, exact = coarse.traction(shear), fine.traction(shear)
    strain = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    tau = 5.0 * coarse.normals @ strain  # exactly 5 mu E n on a sphere whose surface moves by E x
    error = np.sqrt(coarse.weights @ np.sum((found.values - tau) ** 2, axis=1))
    error /= np.sqrt(coarse.weights @ np.sum(tau**2, axis=1))
    assert found.error.mesh == pytest.approx(error, rel=0.25)
    assert found.error.verdict is Verdict.MISSED
    assert "times smaller there" in found.error.advice
    assert exact.error.verdict is Verdict.MET


@pytest.mark.parametrize("gap", [0.3, 1e-5])
def test_spheres_approach_at_gaps_that_their_mesh_does_not_resolve(gap):
    one = sphere(6, 6)
    both = union(one, one)
    c = np.concatenate([one.coefficients, one.coefficients + (2.0 + gap) * Z])
    flow = StokesFlow(both, c, tolerance=1e-2)
    found = flow.traction(lambda x: np.where(x[:, 2:] < 1.0 + 0.5 * gap, Z, -Z))
    assert found.error.verdict is Verdict.MISSED
    assert found.error.mesh > (1.0 if gap < 0.1 else 0.02)
    assert flow.facing.distance == pytest.approx(gap, rel=1e-6)
    if gap < 0.1:
        assert "film lengths" in found.error.advice
        unmeasured = StokesFlow(both, c, tolerance=1e-2, measure="operator").traction(Z)
        assert unmeasured.error.verdict is Verdict.CANNOT_TELL


def test_nothing_to_solve_has_no_error():
    flow = StokesFlow(sphere(4, 4), measure="operator")
    found = flow.traction(np.zeros(3))
    assert found.error.quadrature == 0.0
    assert not np.any(found.coefficients)


def test_unequal_viscosities_are_measured_too():
    """A drop's surface moves with its fluid: the double layer's rule counts as well."""
    body = sphere(6, 6)
    flow = StokesFlow(body, viscosity_ratio=0.5, tolerance=1e-3)
    found = flow.traction(lambda x: x * [1.0, 1.0, -2.0])
    assert 0.0 < found.error.quadrature < 1e-3
    assert found.error.mesh > found.error.quadrature


def test_unknown_measure_is_refused():
    with pytest.raises(ValueError, match=r"measure must be one of .*'operator'.*got 'mesh'"):
        StokesFlow(sphere(4, 4), measure="mesh")


@pytest.mark.parametrize(
    ("estimates", "left"),
    [((1e-3,), 1e-3), ((1e-1, 1e-3), 3e-5), ((1e-1, 9e-2), 9e-2), ((0.0,), 0.0)],
)
def test_what_corrections_leave(estimates, left):
    assert remaining(estimates) == pytest.approx(left)


@pytest.mark.parametrize(
    ("found", "left"),
    [((1e-3,), 1e-3), ((1e-1, 1e-3), 1e-3), ((1e-2, 8e-3), 3.2e-2), ((1e-4, 2e-4), 1.8e-3)],
)
def test_what_finer_rules_leave(found, left):
    """No less than the last difference; the more, the less they shrink."""
    assert left_by_rules(found) == pytest.approx(left)


@pytest.mark.parametrize("name", FLOWS)
def test_rules_of_even_and_odd_orders_err_apart(name):
    """In a thin gap the next plain rule differed by a quarter of the error."""
    body = round_bag(8, gap=0.05).patches()
    flow = StokesFlow(body, tolerance=1e-4, measure="operator")
    finest = replace(FINEST, far=12)
    exact = StokesFlow(body, orders=finest, measure="none").traction(FLOWS[name])
    tested, _ = flow._tested(FLOWS[name](flow.points))
    plain = flow.formulation.system.solve(flow.formulation.data(tested))
    error = flow.solver.size(plain.solution - exact.coefficients.ravel())
    error /= flow.solver.size(exact.coefficients.ravel())
    found = flow.solver.refined(Measured(plain), tested)
    assert found.quadrature[0] == pytest.approx(error, rel=0.3)


def test_verdicts_say_what_is_known():
    met = TractionError(1e-3, 1e-4, 1e-4, 0.0, 1e-6)
    assert met.verdict is Verdict.MET
    assert met.total == pytest.approx(2.01e-4)
    assert TractionError(1e-3, np.nan, 1e-4, 0.0, 1e-6).verdict is Verdict.CANNOT_TELL
    assert TractionError(1e-3, 9e-4, 0.0, 0.0, 0.0).verdict is Verdict.CANNOT_TELL  # too near
    assert TractionError(1e-3, np.nan, 1e-2, 0.0, 1e-6).verdict is Verdict.MISSED
    assert TractionError(1e-3, 1e-4, 1e-4, 0.0, 0.0, resolved=False).verdict is Verdict.CANNOT_TELL
    assert str(met).startswith("met: mesh 1.0e-04, quadrature and compression 1.0e-04")
    assert met.describe()["verdict"] == "met"


def test_a_solver_keeps_what_it_built():
    flow = StokesFlow(sphere(4, 4), measure="operator")
    flow.traction(Z)
    solver = flow.solver
    assert isinstance(solver, MeasuredSolve)
    first = solver.finest
    flow.traction(X)
    assert solver.finest is first
