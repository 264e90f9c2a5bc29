"""Every scheme on the linear fixed point x -> -rho x + b, through the real protocols.

Structure: x = b + load; fluid: load = -rho dt v with v = x / dt (added damping of strength rho).
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse.linalg import aslinearoperator

from coupling.attempt import StepProblem
from coupling.automatic import Automatic
from coupling.fixed_point import Partitioned, iterate
from coupling.implicit import Implicit, StructureOnly
from coupling.protocols import Result, State, Traction
from coupling.quasi_newton import QuasiNewton
from coupling.relaxation import Aitken, Constant, GaussSeidel, Memory

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
        return Traction(self.rho * self.dt * velocity, 0.0)

    def load(self, traction):
        return -traction.coefficients

    def drive(self):
        return None

    def response(self):
        operator = aslinearoperator(-self.rho * self.dt * np.eye(B.size))
        operator.dense = lambda: -self.rho * self.dt * np.eye(B.size)
        return operator


def attempt(scheme, rho, iterations=40):
    state = State(0.0, np.zeros_like(B), np.zeros_like(B))
    fluid = LinearFluid(rho, 0.1)
    problem = StepProblem(
        LinearStructure(), fluid, state, 0.1, 1.0, 1e-10, 1e-14, iterations, lambda *a: None
    )
    return scheme.attempt(problem, scheme.init()), fluid


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
    assert result.cause is None
    assert result.step.state.coefficients == pytest.approx(B / (1.0 + rho), rel=1e-9)
    assert result.assemblies == fluid.assemblies


@pytest.mark.parametrize("rho", [0.9, 1.1])
def test_gauss_seidel_diverges_iff_rho_exceeds_one(rho):
    result, _ = attempt(Partitioned(GaussSeidel()), rho, 400)
    assert (result.cause is None) == (rho < 1.0)
    if rho > 1.0:
        assert result.cause is Result.COUPLING


def test_aitken_is_exact_on_one_mode():
    """Two residuals determine a linear scalar problem: the third evaluation confirms."""
    result, fluid = attempt(Partitioned(Aitken()), 50.0)
    assert result.cause is None
    assert fluid.assemblies == 3


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
    assert aitken.next_step(Memory(-0.9)).factor == -0.5
    assert aitken.next_step(Memory(0.2)).factor == 0.2


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
    assert result.cause is None
    assert fluid.assemblies == 0


def test_bad_relaxation_is_refused():
    with pytest.raises(ValueError, match=r"\(0, 1\]"):
        Constant(1.5)


def automatic(rate):
    return Automatic(rate, Partitioned(GaussSeidel()), Implicit(), rest=2)


def test_small_rho_takes_the_cheap_scheme():
    result, _ = attempt(automatic(1.0), 0.05)
    assert result.cause is None
    assert not result.notes
    assert result.iterations > 2  # gauss-seidel's, to 1e-10
    assert "cheap.load" in result.memory


def test_large_rho_takes_the_robust_scheme():
    result, _ = attempt(automatic(1e5), 1e4)
    assert result.cause is None
    assert result.assemblies == 2


def test_change_when_the_forecast_was_wrong():
    """rho is 50, the forecast says 0.1: gauss-seidel fails, the step is solved all the same."""
    result, fluid = attempt(automatic(1.0), 50.0)
    assert result.cause is None
    assert result.step.state.coefficients == pytest.approx(B / 51.0, rel=1e-9)
    assert Result.COUPLING.name in result.notes[0]
    assert result.assemblies == fluid.assemblies
    assert int(result.memory["rest"]) == 2


def test_memory_holds_arrays_only():
    result, _ = attempt(automatic(1.0), 0.05)
    assert all(isinstance(v, np.ndarray) for v in result.memory.values())
