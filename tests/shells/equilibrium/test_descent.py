"""Steps in time by a Newton that always descends: snaps, damping, contact."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.sparse.linalg import aslinearoperator

import shells
from cases.geometry.revolution import sphere
from shells.conditions.supports import extraction
from shells.equilibrium.balance import Balance
from shells.equilibrium.descent import Descent
from shells.equilibrium.minimise import minimise
from shells.equilibrium.modes import lowest_modes
from shells.equilibrium.newton import NewtonOutcome
from shells.equilibrium.state import ShellState

from .test_newton import snapping_roof


def ball(contact=None, **settings):
    """A sphere of radius 1 and its structure."""
    surface, c = sphere(3, 4, 8)
    basis = shells.SurfaceBasis(surface, c)
    shell = shells.KirchhoffLove(basis, shells.Material(1e-3, poisson_ratio=0.3))
    E, volume = extraction(surface.reduction), shells.EnclosedVolume(basis)
    return shells.ShellStructure(shell, E, volume, contact=contact, **settings), c


def at_rest(c):
    return ShellState(0.0, c, np.zeros_like(c))


@dataclass
class Floor:
    """A plane below a structure's control points, which rises with a speed."""

    height: float
    reach: float = 0.2
    stiffness: float = 1e-2
    speed: float = 0.0
    ways: list = field(default_factory=list)

    def at(self, t):
        return Floor(self.height + self.speed * t, self.reach, self.stiffness, 0.0, self.ways)

    def _s(self, c):
        return np.minimum((c[:, 2] - self.height) / self.reach, 1.0)

    def energy(self, c):
        s = self._s(c)
        return (
            np.inf if s.min() <= 0.0 else -self.stiffness * float(((1 - s) ** 2 * np.log(s)).sum())
        )

    def derivatives(self, c, projected=True):
        s = self._s(c)
        g, h = np.zeros_like(c), np.zeros_like(c)
        g[:, 2] = self.stiffness / self.reach * (2 * (1 - s) * np.log(s) - (1 - s) ** 2 / s)
        bend = -2 * np.log(s) + 4 * (1 - s) / s + (1 - s) ** 2 / s**2
        h[:, 2] = self.stiffness / self.reach**2 * bend
        return g.ravel(), diags(h.ravel()).tocsr()

    def free_step(self, start, end):
        a, b = start[:, 2] - self.height, end[:, 2] - self.height
        assert a.min() > 0.0
        down = b < a
        free = float(np.min(0.9 * a[down] / (a - b)[down], initial=np.inf))
        self.ways.append(min(free, 1.0))
        return min(free, 1.0)

    def distance(self, c):
        s = self._s(c)
        return float(s.min() * self.reach) if s.min() < 1.0 else np.inf


@pytest.mark.parametrize("dt", [1e2, 1e4])
@pytest.mark.parametrize("share", [0.8, 1.0])
def test_a_roof_snaps_in_one_step(share, dt):
    """Plain Newton cycles at 0.8 of the load, and ends in a higher state at 1.0 and 1e4."""
    shell, E, c, load = snapping_roof()
    structure = shells.ShellStructure(shell, E)
    linear = -(E.T @ load(share).ravel())
    balance = Balance(structure, c, None, linear, structure.M_free / dt**2)
    still = np.zeros_like(linear)

    def energy(q):
        return balance.potential(q)[0] + q @ (linear + 0.5 * (balance.operator @ q))

    heights = []

    class Watched(Balance):
        def equations(self, q, *rest):
            heights.append(energy(q))
            return super().equations(q, *rest)

    plain = balance.solve(still, 0.0)
    assert share == 1.0 or plain.outcome is NewtonOutcome.LIMIT
    end = Descent(Watched(*vars(balance).values())).solve(still, 0.0)
    assert end.outcome is NewtonOutcome.CONVERGED
    assert len(end.history) <= 16
    assert np.all(np.diff(heights) < 1e-12 * abs(heights[-1]))
    assert energy(end.x) <= energy(plain.x) * (1.0 - 1e-12)
    assert np.linalg.norm(balance.equations(end.x, 0.0, False).residual) < 1e-9 * np.linalg.norm(
        linear
    )


@pytest.mark.parametrize("reuse", [0.0, 0.5])
def test_steps_that_newton_solves_are_the_same(reuse):
    """Same iterates to rounding, same counts of iterations and factors."""
    structure, c = ball(reuse=reuse)
    volume = 1.02 * structure.volume(c)
    state = at_rest(c)
    linear = np.zeros(structure.E.shape[1])
    balance = Balance(structure, c, volume, linear, structure.M_free / 0.5**2)
    plain = balance.solve(linear, 0.0)
    step = structure.step(state, None, 0.5, volume)
    assert step.ok
    assert step.newton_iterations == len(plain.history)
    assert step.factorizations == plain.factorizations
    assert structure.reduce(step.state.coefficients - c) == pytest.approx(plain.x, abs=1e-14)
    assert step.state.pressure == pytest.approx(-plain.multiplier, rel=1e-12)


@pytest.mark.parametrize("dense", [True, False])
def test_a_damping_that_is_not_symmetric(dense, monkeypatch):
    """As an array and by its action, which is asked once an iteration outside of GMRES."""
    structure, c = ball()
    rng, n = np.random.default_rng(3), c.size
    F, S = rng.standard_normal((n, 20)), rng.standard_normal((n, n))
    C = 0.1 * F @ F.T + 1e-2 * (S - S.T)
    shear = ShellState(0.0, c, 0.3 * c * [1.0, -1.0, 0.5])
    asked = []
    for name in ("forces", "drag"):
        method = getattr(Balance, name)
        counted = lambda b, q, method=method: asked.append(q) or method(b, q)  # noqa: E731
        monkeypatch.setattr(Balance, name, counted)
    volume = 1.01 * structure.volume(c)
    step = structure.step(shear, None, 0.2, volume, damping=C if dense else aslinearoperator(C))
    assert step.ok
    v = step.state.velocity.ravel()
    force = structure.M @ (v - shear.velocity.ravel()) / 0.2 + C @ v
    force += structure.shell.gradient(step.state.coefficients)
    force -= step.state.pressure * structure.enclosure.gradient(step.state.coefficients)
    assert np.abs(structure.E.T @ force).max() < 1e-8 * np.abs(structure.E.T @ (C @ v)).max()
    assert structure.volume(step.state.coefficients) == pytest.approx(volume, rel=1e-10)
    assert len(asked) == step.newton_iterations


def test_a_ball_lands_on_a_plane_and_is_pushed_by_it():
    """It stays above, its energy balances, and only where the plane rises is work done by it."""
    floor = Floor(-1.3)
    structure, c = ball(floor)
    state = ShellState(0.0, c, np.tile([0.0, 0.0, -2.0], (len(c), 1)))
    volume = structure.volume(c)
    plain, _ = ball()
    through = plain.step(state, None, 0.5, volume)
    assert through.state.coefficients[:, 2].min() < -1.3  # the predictor is below the plane
    balance = sum(structure.energies(state).values())
    for _ in range(4):
        step = structure.step(state, None, 0.5, volume)
        assert step.ok
        assert step.state.coefficients[:, 2].min() > -1.3
        work = structure.budget(state, step.state, None)
        balance += work["pressure_work"] - work["dissipation"]
        assert work["load_work"] == 0.0
        state = step.state
    assert min(floor.ways) < 1.0
    assert sum(structure.energies(state).values()) == pytest.approx(balance, rel=1e-5)
    assert "contact" not in plain.energies(state)
    rising, _ = ball(Floor(-1.34, speed=0.02))  # at -1.3 by now
    last = state
    pushed = rising.step(last, None, 0.5, volume)
    work = rising.budget(last, pushed.state, None)
    change = sum(rising.energies(pushed.state).values()) - sum(rising.energies(last).values())
    assert work["load_work"] > 0.0
    done = work["load_work"] + work["pressure_work"] - work["dissipation"]
    assert change == pytest.approx(done, rel=1e-4)


class Crease(Floor):
    """Pushes towards a height from both sides, with a force that jumps there."""

    def at(self, t):
        return self

    def energy(self, c):
        return 2e-3 * abs(c[:, 2].mean() - self.height)

    def derivatives(self, c, projected=True):
        g = np.zeros_like(c)
        g[:, 2] = 2e-3 * np.sign(c[:, 2].mean() - self.height) / len(c)
        return g.ravel(), diags(np.zeros(c.size)).tocsr()

    def free_step(self, start, end):
        return 1.0


def test_a_minimum_in_a_kink_of_contact_is_found():
    """The residual does not vanish there: it was halved for 25 iterations, and rejected."""
    structure, c = ball(Crease(0.01998))
    state = ShellState(0.0, c, np.tile([0.0, 0.0, 0.04], (len(c), 1)))
    step = structure.step(state, None, 0.5, structure.volume(c))
    assert step.ok
    assert step.state.coefficients[:, 2].mean() == pytest.approx(0.01998, abs=2e-6)
    assert structure.volume(step.state.coefficients) == pytest.approx(structure.volume(c), rel=1e-9)


def test_failures_leave_the_state(monkeypatch):
    structure, c = ball(max_iterations=1)
    state = at_rest(c)
    step = structure.step(state, None, 0.5, 1.5 * structure.volume(c))
    assert step.outcome is NewtonOutcome.LIMIT
    assert np.array_equal(state.coefficients, c)
    inside, _ = ball(Floor(-0.5))
    monkeypatch.setattr(Floor, "free_step", lambda *ways: 0.005)
    assert inside.step(state, None, 0.5, structure.volume(c)).outcome is NewtonOutcome.DIVERGED
    touching, _ = ball(Floor(-1.1))
    stuck = touching.step(state, None, 0.5, structure.volume(c))
    assert stuck.outcome is NewtonOutcome.BLOCKED
    assert stuck.newton_iterations == 3
    with pytest.raises(ValueError, match="static equilibria know no contact"):
        touching.static(c)
    with pytest.raises(ValueError, match="minima of the potential know no contact"):
        minimise(touching, c, 1e-3)
    with pytest.raises(ValueError, match="modes know no contact"):
        lowest_modes(touching, c)


def test_enormous_ways_are_cut_before_they_are_tested():
    """A contact is never asked about a way longer than a fifth of the structure."""
    asked = []

    class Far(Floor):
        def free_step(self, start, end):
            asked.append(np.abs(end - start).max())
            return super().free_step(start, end)

    structure, c = ball(Far(-50.0))
    balance = Balance(structure, c, None, np.zeros(structure.E.shape[1]), contact=Far(-50.0))
    q = np.zeros(structure.E.shape[1])
    d = np.random.default_rng(0).standard_normal(q.size)
    assert balance.free_step(q, 1e-3 * d) == 1.0
    share = balance.free_step(q, 1e4 * d)
    assert share == pytest.approx(0.2 * structure.length / (1e4 * np.abs(d).max()))
    assert max(asked) < 0.5 * structure.length
