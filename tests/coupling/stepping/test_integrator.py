"""Orders, damping of stiff modes and error estimates on one oscillator."""

import numpy as np
import pytest

from coupling.exchange import State
from coupling.stepping.integrator import BDF2, BackwardEuler


def oscillate(integrator, steps, omega=1.0, end=2.0):
    """x'' = -omega^2 x from x = 1, by steps whose length alternates 1 : 1.5."""
    lengths = np.where(np.arange(steps) % 2, 1.5, 1.0)
    lengths *= end / lengths.sum()
    state, past, errors = State(0.0, np.ones((1, 3)), np.zeros((1, 3))), {}, []
    for dt in lengths:
        base, length = integrator.base(state, past, dt)
        x = (base.coefficients + length * base.velocity) / (1.0 + (omega * length) ** 2)
        new = State(base.t + length, x, (x - base.coefficients) / length)
        estimate = integrator.error(state, new, past, dt)[0, 0]
        a = state.coefficients[0, 0], state.velocity[0, 0] / omega
        s, c = np.sin(omega * dt), np.cos(omega * dt)
        errors.append((estimate, a[0] * c + a[1] * s - x[0, 0]))
        past, state = integrator.past(state, dt), new
    assert state.t == pytest.approx(end, rel=1e-12)
    return state, errors


@pytest.mark.parametrize(("integrator", "order"), [(BackwardEuler(), 1), (BDF2(), 2)])
def test_order_with_varying_steps(integrator, order):
    errors = [abs(oscillate(integrator, n)[0].coefficients[0, 0] - np.cos(2.0)) for n in (80, 160)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_second_order_damps_less_where_resolved_and_all_where_stiff():
    energy = {}
    for name, integrator in (("euler", BackwardEuler()), ("bdf2", BDF2())):
        state, _ = oscillate(integrator, 40)
        energy[name] = float(state.coefficients[0, 0] ** 2 + state.velocity[0, 0] ** 2)
        stiff, _ = oscillate(integrator, 10, omega=1e4)
        assert abs(stiff.coefficients[0, 0]) < 1e-10
    # theory: euler loses exp(-dt t omega^2) of the energy, bdf2 O(dt^3)
    assert energy["euler"] == pytest.approx(np.exp(-0.05 * 2.0), rel=0.01)
    assert energy["bdf2"] == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("integrator", [BackwardEuler(), BDF2()])
def test_error_estimate(integrator):
    """Against the true local error, which carries that of the velocity too, to a factor 3."""
    _, errors = oscillate(integrator, 100)
    for estimate, true in errors[10:40]:
        assert 1.0 / 3.0 < abs(estimate / true) < 3.0
