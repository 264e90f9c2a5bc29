"""Every scheme on the linear fixed point x -> -rho x + b, through the real protocols.

Structure: x = b + load; fluid: load = -rho dt v with v = x / dt (added damping of strength rho).
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import aslinearoperator

from coupling.exchange import Result, State
from coupling.schemes.automatic import Automatic
from coupling.schemes.fixed_point import Partitioned, iterate
from coupling.schemes.implicit import Implicit, StructureOnly
from coupling.schemes.quasi_newton import QuasiNewton
from coupling.schemes.relaxation import Aitken, Constant, GaussSeidel, RelaxationMemory
from coupling.schemes.scheme import StepProblem, StepResult

B = np.array([[1.0, -2.0, 0.5], [0.3, 0.7, -1.1]])


@dataclass(frozen=True)
class Step:
    state: State
    newton_iterations: int = 1
    ok: bool = True
    outcome: object = None


class LinearStructure:
    def step(self, state, load, dt, volume, damping=None, guess=None):
        x = B if load is None else B + load
        if damping is not None:
            C = damping.dense()
            x = np.linalg.solve(np.eye(B.size) + C / dt, x.ravel()).reshape(B.shape)
        return Step(State(state.t + dt, x, x / dt))

    def linearised(self, state, dt):
        return aslinearoperator(np.eye(B.size))

    def measure(self, increment):
        return float(np.sqrt(np.mean(increment**2)))


@dataclass
class LinearFluid:
    rho: float
    dt: float
    assemblies: int = 0

    def assemble(self, coefficients):
        self.assemblies += 1
        return self

    def reset(self):
        self.assemblies = 0

    def traction(self, velocity):
        rest = {"flux": 0.0, "velocity_max": 0.0, "iterations": 0, "residual": 0.0}
        return SimpleNamespace(coefficients=self.rho * self.dt * velocity, zeta=0.0, **rest)

    def load(self, traction):
        return -traction.coefficients

    def drive(self):
        return None

    def response(self):
        operator = aslinearoperator(-self.rho * self.dt * np.eye(B.size))
        operator.dense = lambda: -self.rho * self.dt * np.eye(B.size)
        return operator


def attempt(scheme, rho, iterations=40, memory=None, **tests):
    state = State(0.0, np.zeros_like(B), np.zeros_like(B))
    fluid = LinearFluid(rho, 0.1)
    problem = StepProblem(
        LinearStructure(),
        fluid,
        state,
        0.1,
        1.0,
        1e-10,
        1e-14,
        iterations,
        lambda *a: None,
        **tests,
    )
    return scheme.attempt(problem, scheme.init() if memory is None else memory), fluid


def automatic(rate=1.0, **options):
    return Automatic(
        rate, Partitioned(GaussSeidel()), Implicit(), limit=0.3, remeasure_every=2, **options
    )


@pytest.mark.parametrize(
    ("scheme", "rho"),
    [
        (Implicit(), 1e4),
        (Implicit(passes=1), 1e4),
        (Partitioned(QuasiNewton()), 200.0),
        (Partitioned(Aitken()), 15.0),
        (Partitioned(Constant(0.2)), 4.0),
        (Partitioned(GaussSeidel()), 0.4),
    ],
)
def test_schemes_find_the_fixed_point(scheme, rho):
    result, fluid = attempt(scheme, rho)
    assert result.failure is None
    assert result.step.state.coefficients == pytest.approx(B / (1.0 + rho), rel=1e-9)
    assert result.assemblies == fluid.assemblies


@pytest.mark.parametrize("rho", [0.9, 1.1])
def test_gauss_seidel_diverges_iff_rho_exceeds_one(rho):
    result, _ = attempt(Partitioned(GaussSeidel()), rho, 400)
    assert (result.failure is None) == (rho < 1.0)
    if rho > 1.0:
        assert result.failure is Result.COUPLING


def test_aitken_is_exact_on_one_mode():
    """Two residuals determine a linear scalar problem: the third evaluation confirms."""
    result, fluid = attempt(Partitioned(Aitken()), 50.0)
    assert result.failure is None
    assert fluid.assemblies == 3


@pytest.mark.parametrize(
    "scheme", [Partitioned(QuasiNewton()), Partitioned(Aitken()), Implicit(), automatic()]
)
def test_relaxed_iterates_that_cross_fall_back_to_the_structures(scheme):
    """Three guesses are refused: what the structure reached, or the accepted one, is assembled."""
    asked, reached = [], []

    def inspect(x):
        asked.append(x)
        return None if len(asked) > 3 else Result.SELF_INTERSECTION

    result, _ = attempt(scheme, 0.7, 200, inspect=inspect, verify=reached.append)
    assert result.failure is None
    assert result.step.state.coefficients == pytest.approx(B / 1.7, rel=1e-9)
    assert reached
    refused, _ = attempt(
        scheme,
        0.7,
        inspect=lambda x: Result.SELF_INTERSECTION,
        verify=lambda x: Result.SELF_INTERSECTION,
    )
    assert refused.failure is Result.SELF_INTERSECTION


def test_implicit_needs_one_correction_only():
    result, _ = attempt(Implicit(), 1e3)
    assert result.iterations == 2  # the second pass confirms an unchanged geometry


def test_aitken_factor_by_hand():
    """preCICE's formula on two hand-computed iterates."""
    aitken = Aitken(0.5)
    x, memory = aitken.step(aitken.init(), np.array([0.0, 0.0]), np.array([1.0, 2.0]))
    assert x == pytest.approx([0.5, 1.0])
    x, memory = aitken.step(memory, x, np.array([-0.5, 0.0]))
    # dr = (-1.5, -2), w = -0.5 * <(1, 2), dr> / <dr, dr> = 0.5 * 5.5 / 6.25
    assert memory.factor == pytest.approx(0.44, rel=1e-14)
    assert x == pytest.approx([0.5 - 0.22, 1.0])
    assert aitken.next_step(RelaxationMemory(-0.9)).factor == -0.5
    assert aitken.next_step(RelaxationMemory(0.2)).factor == 0.2


def test_bare_iteration_reports_failure():
    _, evaluations, converged = iterate(
        lambda x: -3.0 * x + 1.0, np.zeros(2), GaussSeidel(), tolerance=1e-10, max_iterations=50
    )
    assert not converged
    assert evaluations == 50
    x, _, converged = iterate(
        lambda x: -3.0 * x + 1.0, np.zeros(2), Constant(0.25), tolerance=1e-10, max_iterations=50
    )
    assert converged
    assert x == pytest.approx(0.25)


def test_structure_only_has_no_assembly():
    result, fluid = attempt(StructureOnly(), 1.0)
    assert result.failure is None
    assert fluid.assemblies == 0


def test_what_there_is_not_is_named():
    state = State(0.0, np.zeros_like(B), np.zeros_like(B))
    problem = StepProblem(
        LinearStructure(), None, state, 0.1, 1.0, 1e-10, 0.0, 5, lambda *args: None
    )
    with pytest.raises(ValueError, match="use StructureOnly"):
        Implicit().attempt(problem, {})
    with pytest.raises(ValueError, match="was not solved"):
        _ = StepResult(Result.NEWTON).state


def test_bad_relaxation_is_refused():
    with pytest.raises(ValueError, match=r"\(0, 1\]"):
        Constant(1.5)


def test_small_rho_takes_the_cheap_scheme():
    """Measured, whatever the forecast said."""
    result, fluid = attempt(automatic(rate=1e5), 0.05)
    assert result.failure is None
    assert "cheap scheme: measured rho = 0.05" in result.notes[0]
    assert result.iterations > 2  # gauss-seidel's, to 1e-10
    assert "cheap.load" in result.memory
    assert result.assemblies == fluid.assemblies == result.iterations + 1


def test_large_rho_takes_the_robust_scheme():
    """The measurement costs no assembly: the robust scheme goes on with its operator."""
    result, fluid = attempt(automatic(rate=1e-5), 1e4)
    assert result.failure is None
    assert "robust scheme: measured rho = 1e+04" in result.notes[0]
    assert result.assemblies == fluid.assemblies == 2
    assert float(result.memory["rate"]) == pytest.approx(1e5, rel=0.05)


def test_change_when_the_measurement_was_wrong():
    """rho is 50, memory says 0.1: gauss-seidel fails, the step is solved all the same."""
    scheme = automatic()
    memory = {**scheme.init(), "rate": np.array(1.0), "turn": np.array(1)}
    result, fluid = attempt(scheme, 50.0, memory=memory)
    assert result.failure is None
    assert result.step.state.coefficients == pytest.approx(B / 51.0, rel=1e-9)
    assert Result.COUPLING.name in result.notes[0]
    assert result.assemblies == fluid.assemblies
    assert int(result.memory["left"]) == 2


def test_a_busy_step_ends_the_cheap_turn_and_the_first_may_take_longer():
    scheme = automatic(max_subiterations=8)
    first, _ = attempt(scheme, 0.2)
    assert first.iterations > 3
    assert (int(first.memory["left"]), int(first.memory["turn"])) == (0, 1)
    second, _ = attempt(scheme, 0.25, memory=first.memory)
    assert second.iterations > 3
    assert (int(second.memory["left"]), int(second.memory["turn"])) == (2, 0)
    third, _ = attempt(scheme, 0.25, memory=second.memory)
    assert third.iterations == 2  # implicit


def test_memory_holds_arrays_only():
    for rho in (0.05, 1e3):
        result, _ = attempt(automatic(), rho)
        assert all(isinstance(v, np.ndarray) for v in result.memory.values())


def test_geometry_differences_carry_over():
    """The implicit scheme's memory is that of its geometry iteration; a rejection clears it."""
    scheme = Implicit()
    result, _ = attempt(scheme, 10.0)
    assert not scheme.reset(result.memory)


class CurvedStructure(LinearStructure):
    """One that moves with acceleration, whatever the load."""

    def step(self, state, load, dt, volume, damping=None, guess=None):
        x = (state.t + dt) ** 2 * B
        return Step(State(state.t + dt, x, (x - state.coefficients) / dt))


def test_implicit_predicts_with_acceleration():
    """A quadratic motion is predicted exactly from its third step on."""
    fluid, scheme, state = LinearFluid(1.0, 1.0), Implicit(), State(0.0, 0.0 * B, 0.0 * B)
    memory, counts = scheme.init(), []
    for _ in range(6):
        problem = StepProblem(
            CurvedStructure(), fluid, state, 1.0, 1.0, 1e-2, 0.0, 9, lambda *args: None
        )
        result = scheme.attempt(problem, memory)
        counts.append(result.assemblies)
        state, memory = result.state, result.memory
    assert counts == [2, 2, 1, 1, 1, 1]
