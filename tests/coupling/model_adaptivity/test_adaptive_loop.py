"""Goals, estimates, markings, the adaptive loop and adapted meshes on the channel with a cavity."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cases.kinds.adaptive_flow.build import flow_on
from cases.kinds.adaptive_flow.geometry import channel_cavity, with_names
from coupling.model_adaptivity import adaptive_loop as loop
from coupling.model_adaptivity import goals, mesh_adaptivity
from coupling.model_adaptivity.adaptive_loop import AdaptationResult, Strategy, adapt, full_model
from coupling.model_adaptivity.error_estimate import add_layers, dual, estimate, indicators
from coupling.model_adaptivity.marking import mark
from coupling.navier_stokes.newton import Newton, Solution, solve_robustly

CORNER = (1.9, 2.0, -1.0, -0.9)


@pytest.fixture(scope="module")
def flow():
    return flow_on(channel_cavity(10), 10.0)


@pytest.fixture(scope="module")
def goal(flow):
    return goals.vorticity(flow.space, goals.region(flow.space, CORNER))


@pytest.fixture
def field(flow):
    return np.random.default_rng(0).standard_normal(flow.space.n)


@pytest.mark.parametrize("kind", ["vorticity", "kinetic", "point", "traction"])
def test_goals_have_their_derivatives(flow, goal, field, kind):
    made = {
        "vorticity": lambda: goal,
        "kinetic": lambda: goals.kinetic_energy(flow.space),
        "point": lambda: goals.point_value(flow.space, (1.5, -0.5), 0.2),
        "traction": lambda: goals.boundary_force(flow, "walls", (1.0, 0.5)),
    }[kind]()
    step = np.random.default_rng(1).standard_normal(field.size)
    # at most quadratic: central differences are exact
    difference = made.value(field + 0.5 * step) - made.value(field - 0.5 * step)
    assert made.derivative(field) @ step == pytest.approx(difference, rel=1e-9)


def test_goal_values_of_known_fields(flow):
    space = flow.space
    x, y = space.velocity.doflocs
    shear = np.concatenate([y**2, 3 * x, np.zeros(space.pressure.N)])
    box = goals.region(space, CORNER)
    # int (2 y - 3) over [1.9, 2] x [-1, -0.9]
    assert goals.vorticity(space, box).value(shear) == pytest.approx(0.01 * (-1.9 - 3.0))
    ones = np.concatenate([np.ones(2 * space.n_velocity), np.zeros(space.pressure.N)])
    assert goals.kinetic_energy(space).value(ones) == pytest.approx(4.0)
    assert goals.point_value(space, (1.5, -0.5), 0.2).value(ones) == pytest.approx(1.0)


def test_force_on_the_walls_balances_the_momentum(flow):
    x = solve_robustly(flow, flow.everywhere).x
    walls, inlet = (goals.boundary_force(flow, name, (1.0, 0.0)) for name in ("walls", "inlet"))
    force = goals.BoundaryForce(flow, np.maximum(walls.lift, inlet.lift)).value(x)
    # x-momentum: tractions on walls and inlet carry what leaves less what enters
    basis = flow.convection.outlet
    u = np.asarray(basis.interpolate(flow.space.split(x)[0]))
    leaving = float((basis.dx * u * u).sum())
    entering = 8.0 / 15.0
    n = flow.space.n_velocity
    carried = float(flow.convection.vector(x, flow.everywhere)[:n].sum())
    assert force == pytest.approx(carried, rel=1e-10)
    assert force == pytest.approx(leaving - entering, abs=1e-4)  # div u = 0 holds weakly


@pytest.mark.parametrize(
    ("box", "word"),
    [((1.9, 2.1, -1.0, -0.9), "whole elements cover"), ((1.84, 2.0, -1.0, -0.9), "reach out")],
)
def test_bad_goal_regions_are_named(flow, box, word):
    with pytest.raises(ValueError, match=word):
        goals.region(flow.space, box)


def test_indicators_add_up_to_the_estimate(flow, goal):
    flagged = flow.space.centres[:, 1] > 0.3
    found = solve_robustly(flow, flagged)
    z = dual(flow, goal, found.x, flow.everywhere)
    wanted = float(flow.residual(found.x, flow.everywhere) @ z)
    for kind in ("integral", "counting", "volume", "exact"):
        eta = indicators(flow, found.x, z, flagged, kind)
        assert eta.sum() == pytest.approx(wanted, rel=1e-9), kind
    assert not indicators(flow, found.x, z, flagged, "integral")[flagged].any()


def test_shares_coincide_on_uniform_meshes(flow, goal):
    found = solve_robustly(flow, flow.nowhere)
    z = dual(flow, goal, found.x, flow.everywhere)
    counting, volume, exact = (
        indicators(flow, found.x, z, flow.nowhere, kind) for kind in ("counting", "volume", "exact")
    )
    assert volume == pytest.approx(counting, abs=1e-18)
    assert exact == pytest.approx(counting, abs=1e-18)
    triangles = flow_on(channel_cavity(4, triangles=True), 10.0)
    with pytest.raises(ValueError, match="use 'volume' or 'counting'"):
        indicators(triangles, triangles.values, triangles.values, triangles.nowhere, "exact")


def test_effectivity_is_one_on_a_linear_problem(flow, goal):
    wind = solve_robustly(flow, flow.everywhere).x
    linear = flow.with_wind(wind)
    reference, _ = full_model(linear, goal)
    steps = list(adapt(linear, goal, Strategy(tolerance=1e-4), reference=reference))
    assert steps[-1].result is AdaptationResult.COMPLETED
    assert len(steps) > 3
    assert [s.effectivity for s in steps] == pytest.approx([1.0] * len(steps), abs=1e-8)


def test_cheaper_adjoints_tend_to_the_full_one(flow, goal):
    flagged = add_layers(flow.space, goals.region(flow.space, CORNER), 4)
    x = solve_robustly(flow, flagged).x
    full = estimate(flow, goal, x, flagged).error
    errors = [
        abs(estimate(flow, goal, x, flagged, adjoint="enriched", layers=k).error / full - 1.0)
        for k in (0, 4, 30)
    ]
    mixed = estimate(flow, goal, x, flagged, adjoint="mixed").error
    assert abs(mixed / full - 1.0) == pytest.approx(errors[0])
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-10  # all elements are reached


def test_markings():
    eta = np.array([5.0, -4.0, 1.0, 0.3, -8.0])
    flagged = np.array([False, False, False, False, True])
    assert np.flatnonzero(mark(eta, flagged, "greedy", 0.5)).tolist() == [0, 1]
    assert np.flatnonzero(mark(eta, flagged, "fraction", 0.6)).tolist() == [0, 1, 2]
    assert np.flatnonzero(mark(eta, flagged, "doerfler", 0.5)).tolist() == [0, 1]
    assert np.flatnonzero(mark(eta, flagged, "doerfler", 0.4)).tolist() == [0]
    assert mark(eta, flagged, "doerfler", 1.0).sum() == 4
    assert not mark(eta, np.ones(5, dtype=bool), "doerfler", 0.5).any()
    with pytest.raises(ValueError, match="lies in"):
        mark(eta, flagged, "greedy", 0.0)


@pytest.fixture(scope="module")
def thesis_loop():
    """Re = 10 on h = 1/20, the thesis' indicators and marking."""
    flow = flow_on(channel_cavity(20), 10.0)
    goal = goals.vorticity(flow.space, goals.region(flow.space, CORNER))
    reference, _ = full_model(flow, goal)
    strategy = Strategy(indicator="counting", tolerance=1e-12)
    return list(adapt(flow, goal, strategy, reference=reference))


def test_the_loop_of_the_thesis(thesis_loop):
    eps = [s.thesis_eps for s in thesis_loop]
    assert eps[0] == pytest.approx(-4.12e-2, rel=5e-3)
    assert abs(eps[-1]) < 1e-12
    assert thesis_loop[-1].result is AdaptationResult.COMPLETED
    # the thesis' fractions belong to h = 1/80 (0.195, 0.392, 0.743); measured here
    fractions = [thesis_loop[i].element_fraction for i in (1, 2, 4)]
    assert fractions == pytest.approx([0.201, 0.425, 0.759], abs=2e-3)
    for step in thesis_loop:
        assert step.bound >= abs(step.estimate)
        if 1e-12 < abs(step.estimate) < 1e-2:
            assert 0.8 < step.effectivity < 1.25
        assert abs(step.algebraic) < 1e-11
        assert step.error_rel_j0 == pytest.approx(step.error / (1.0 - step.error), rel=1e-9)


def test_a_step_that_does_not_converge_carries_no_figures(flow, goal, monkeypatch):
    real, calls = loop.solve_robustly, []

    def failing(problem, flagged, start=None):
        calls.append(flagged.mean())
        if len(calls) == 2:
            return Solution(problem.values, Newton.STALLED, 1.0)
        return real(problem, flagged, start)

    monkeypatch.setattr(loop, "solve_robustly", failing)
    steps = list(adapt(flow, goal, Strategy(tolerance=1e-3)))
    assert np.isnan(steps[1].estimate)
    assert np.isnan(steps[1].bound)
    assert steps[1].result is AdaptationResult.RUNNING
    assert steps[2].element_fraction > steps[1].element_fraction
    assert steps[-1].result is AdaptationResult.COMPLETED
    monkeypatch.setattr(
        loop, "solve_robustly", lambda p, *others: Solution(p.values, Newton.STALLED, 1.0)
    )
    last = list(adapt(flow, goal, Strategy(max_steps=60)))[-1]
    assert last.result is AdaptationResult.NEWTON
    assert not last.result.ok


def test_adapted_meshes_estimate_the_discretisation_error():
    def problem(mesh, degree):
        flow = flow_on(with_names(mesh), 10.0, degree)
        return flow, goals.vorticity(flow.space, goals.region(flow.space, CORNER))

    start = channel_cavity(10, triangles=True)
    levels = list(mesh_adaptivity.refinements(problem, start, 2))
    reference = -7.0718e-5  # 10405 adapted triangles and their estimate
    errors = [reference - level.value for level in levels]
    assert all(abs(b) < 0.6 * abs(a) for a, b in pairwise(errors))
    for level, error in zip(levels, errors, strict=True):
        assert 0.4 < level.error / error < 1.3
        assert level.bound >= abs(level.error)
    # shares are the residual of the richer space against z - I z
    last = levels[-1]
    richer, goal = problem(last.flow.space.mesh, 3)
    u = richer.space.nodal(last.flow.space, last.x)
    z = dual(richer, goal, u, richer.everywhere)
    w = z - richer.space.nodal(last.flow.space, last.flow.space.nodal(richer.space, z))
    w[richer.fixed] = 0.0
    whole = float(richer.residual(u, richer.everywhere) @ w)
    assert last.error == pytest.approx(whole, rel=1e-6)
