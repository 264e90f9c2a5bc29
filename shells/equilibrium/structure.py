"""A shell with an enclosed volume: backward-Euler steps [T 6.11] and static equilibria.

``M ((theta - theta_n)/dt^2 - v_n/dt) + W'(theta) - p Q'(theta) + C v = load, Q(theta) = V`` with
``v = (theta - theta_n)/dt``, solved by Newton on free coefficients ``theta = theta_n + E q``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, splu

from ..conditions.rigid_motions import Mechanism, mechanism
from ..energy.kirchhoff_love import KirchhoffLove
from ..energy.volume import EnclosedVolume
from . import newton
from .damped_tangent import DampedFactor

# A load that follows the configuration: (n_full, 3) to force and its sparse derivative.
Follower = Callable[[np.ndarray], tuple[np.ndarray, csr_matrix]]


@dataclass(frozen=True)
class ShellState:
    """Time, coefficients and velocity ``(n_full, 3)``, excess pressure."""

    t: float
    coefficients: np.ndarray
    velocity: np.ndarray
    pressure: float = 0.0


@dataclass(frozen=True)
class ShellStep:
    """A solved step, or (``ok`` false) why there is none."""

    state: ShellState
    outcome: newton.Outcome
    newton_iterations: int
    last_update: float
    residual: float = np.inf  # over that of the start
    factorizations: int = 0

    @property
    def ok(self) -> bool:
        return self.outcome is newton.Outcome.CONVERGED


class ShellStructure:
    """A Kirchhoff-Love shell, its supports and its enclosed volume.

    Plane curves work alike, with 2 components in place of 3 and their enclosed area as volume.

    Parameters
    ----------
    shell : KirchhoffLove or PlanarMembrane
    extraction : (3 n_full, n_free) sparse matrix
        Supports and poles (`shells.conditions.supports.extraction`); coefficients beyond the shell's own
        never move.
    volume : EnclosedVolume, optional
        Without it there is no constraint and no pressure.
    tolerance : float
        Newton's largest update over the length of the structure.
    solver : callable
        Linear solver of Newton's iteration: `shells.equilibrium.newton.factorize`, or
        `shells.equilibrium.multigrid.multigrid` for very large systems without a volume.
    reuse : float
        Keep a factor while each Newton update is below this fraction of the last (0: never).

    Raises
    ------
    ValueError
        An extraction with too few rows; a moving open edge (see `EnclosedVolume.check`).
    """

    def __init__(
        self,
        shell: KirchhoffLove,
        extraction: csr_matrix,
        volume: EnclosedVolume | None = None,
        *,
        tolerance: float = 1e-9,
        max_iterations: int = 25,
        solver: Callable = newton.factorize,
        reuse: float = 0.0,
    ):
        self._linear_solver, self._reuse = solver, reuse
        self.shell, self.E, self.enclosed = shell, extraction.tocsr(), volume
        self._n = shell.basis.N  # vector dofs of the shell; the rest of a configuration is fixed
        self._d = d = shell.basis.dimension
        if extraction.shape[0] < self._n or extraction.shape[0] % d:
            raise ValueError(f"the extraction needs at least {self._n} rows, {d} a coefficient")
        self._Es = self.E[: self._n]
        if volume is not None:
            volume.check(self._Es)
        self.M = shell.basis.mass(shell.material.density)
        self._Mr = (self._Es.T @ self.M @ self._Es).tocsr()
        extent = np.ptp(shell.basis.reference.value.reshape(-1, d), axis=0)
        self._tolerance, self._limit = tolerance * float(extent.max()), max_iterations

    @cached_property
    def mechanism(self) -> Mechanism:
        """Rigid motions that the supports leave free."""
        return mechanism(self.E, self.shell.basis)

    @cached_property
    def _normal_solver(self) -> Any:
        return splu((self.E.T @ self.E).tocsc())

    def reduce(self, increment: np.ndarray) -> np.ndarray:
        """Free coordinates q of an increment ``(n_full, 3)`` in the range of E."""
        return self._normal_solver.solve(self.E.T @ increment.ravel())

    def volume(self, coefficients: np.ndarray) -> float:
        """Enclosed volume of a configuration ``(n_full, 3)``."""
        if self.enclosed is None:
            raise ValueError("this structure encloses no volume")
        return self.enclosed.value(coefficients.ravel()[: self._n])

    def area(self, coefficients: np.ndarray) -> float:
        """Current area of the shell."""
        basis = self.shell.basis
        jets = basis.jets(coefficients.reshape(-1, self._d)[: self._n // self._d])
        ratio = np.linalg.norm(jets.normal, axis=-1)
        ratio /= np.linalg.norm(basis.reference.normal, axis=-1)
        return float((ratio * basis.dx).sum())

    def measure(self, increment: np.ndarray) -> float:
        """Mass-weighted root mean square of an increment ``(n_full, 3)``."""
        d = increment.ravel()[: self._n]
        density = self.shell.material.density
        return float(np.sqrt(max(d @ (self.M @ d), 0.0) / (density * self.shell.basis.dx.sum())))

    def _solve(
        self,
        start: np.ndarray,
        x: np.ndarray,
        pressure: float,
        volume: float | None,
        linear: np.ndarray,
        operator: Any,
        follower: Follower | None = None,
        damping: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> newton.NewtonResult:
        """Newton on ``W' - p Q' + linear + operator x + damping(x)``.

        The operator is sparse, dense or None; the damping is linear and applied inside GMRES.
        """
        Es, solver = self._Es, self._linear_solver
        if damping is not None:

            def solver(tangent: Any) -> DampedFactor:
                return DampedFactor(self._linear_solver(tangent), damping)

        def system(q: np.ndarray, lam: float, with_tangent: bool = True) -> tuple:
            c = start.ravel()[: self._n] + Es @ q
            if not with_tangent and follower is None and damping is None:
                return self._residual(c, q, lam, volume, linear, operator)
            gradient, tangent = self.shell.gradient_and_tangent(c)
            row, defect = None, 0.0
            if volume is not None:
                Q, dQ, ddQ = self.enclosed.derivatives(c)
                gradient, tangent = gradient + lam * dQ, tangent + lam * ddQ
                row, defect = Es.T @ dQ, Q - volume
            if follower is not None:
                force, slope = follower((start.ravel() + self.E @ q).reshape(-1, self._d))
                gradient = gradient - force.ravel()[: self._n]
                tangent = tangent - slope[: self._n, : self._n]
            K = Es.T @ tangent @ Es
            r = Es.T @ gradient + linear
            if operator is not None:
                r = r + operator @ q
                K = K + operator
                K = np.asarray(K) if isinstance(K, np.matrix) else K
            if damping is not None:
                r = r + damping(q)
            return r, K, row, defect

        return newton.solve(
            system,
            x,
            -pressure,
            tolerance=self._tolerance,
            max_iterations=self._limit,
            solver=solver,
            reuse=self._reuse,
        )

    def _residual(
        self,
        c: np.ndarray,
        q: np.ndarray,
        lam: float,
        volume: float | None,
        linear: np.ndarray,
        operator: Any,
    ) -> tuple:
        """Residual without tangent, for a factor that is kept."""
        gradient, row, defect = self.shell.gradient(c), None, 0.0
        if volume is not None:
            dQ = self.enclosed.gradient(c)
            gradient = gradient + lam * dQ
            row, defect = self._Es.T @ dQ, self.enclosed.value(c) - volume
        r = self._Es.T @ gradient + linear
        return (r if operator is None else r + operator @ q), None, row, defect

    def step(
        self,
        state: ShellState,
        load: np.ndarray | None,
        dt: float,
        volume: float | None,
        damping: Any = None,
        guess: np.ndarray | None = None,
    ) -> ShellStep:
        """One backward-Euler step [T 6.11].

        Parameters
        ----------
        state : ShellState
        load : (n_full, 3) array or None
            Force tested with each function.
        dt : float
        volume : float or None
            Enclosed volume at the new time.
        damping : optional
            C with ``C v`` added to the residual: ``(3 n_full, 3 n_full)`` array or an operator;
            one with ``dense()`` enters the factor, any other is applied inside GMRES.
        guess : (n_full, 3) array, optional
            Start of Newton's iteration; default the predictor ``theta_n + dt v_n``.
        """
        linear = -(self._Mr @ self.reduce(state.velocity)) / dt
        if load is not None:
            linear -= self.E.T @ load.ravel()
        operator = self._Mr / dt**2
        action = None
        if isinstance(damping, LinearOperator) and not hasattr(damping, "dense"):

            def action(q: np.ndarray) -> np.ndarray:
                return self.E.T @ (damping @ (self.E @ q)) / dt

        elif damping is not None:
            C = damping.dense() if hasattr(damping, "dense") else damping
            operator = operator.toarray() + (self.E.T @ (self.E.T @ C.T).T) / dt
        start = guess - state.coefficients if guess is not None else dt * state.velocity
        result = self._solve(
            state.coefficients,
            self.reduce(start),
            state.pressure,
            volume,
            linear,
            operator,
            damping=action,
        )
        increment = (self.E @ result.x).reshape(-1, self._d)
        new = ShellState(
            state.t + dt, state.coefficients + increment, increment / dt, -result.multiplier
        )
        return _step_of(new, result)

    def energies(self, state: ShellState) -> dict[str, float]:
        """Kinetic, membrane and bending energy of a state."""
        membrane, bending = self.shell.energy(state.coefficients.ravel()[: self._n])
        v = state.velocity.ravel()[: self._n]
        return {"kinetic": 0.5 * float(v @ (self.M @ v)), "membrane": membrane, "bending": bending}

    def budget(
        self,
        start: ShellState,
        end: ShellState,
        load: np.ndarray | None,
        acceleration: np.ndarray | None = None,
    ) -> dict[str, float]:
        """Work of pressure and load over a step and the integrator's dissipation.

        ``acceleration`` is the integrator's at the end; its kinetic dissipation is
        ``<M a, d> - (|v_1|_M^2 - |v_0|_M^2) / 2``. Backward Euler (the default) burns
        ``1/2 |v_1 - v_0|_M^2`` and, of the stored energy,
        ``int_0^1 (W'(theta_1) - W'(theta_0 + s d)).d ds`` (five Gauss points), so that the sum
        with the energies' change measures Newton's residual and nothing else.
        """
        n = self._n
        c0, c1 = start.coefficients.ravel()[:n], end.coefficients.ravel()[:n]
        d, dv = c1 - c0, (end.velocity - start.velocity).ravel()[:n]
        s, w = np.polynomial.legendre.leggauss(5)
        path = sum(
            0.5 * wi * (self.shell.gradient(c0 + 0.5 * (si + 1.0) * d) @ d)
            for si, wi in zip(s, w, strict=True)
        )
        stored = float(self.shell.gradient(c1) @ d - path)
        work = 0.0 if load is None else float(load.ravel()[:n] @ d)
        pressure = 0.0
        if self.enclosed is not None:
            pressure = end.pressure * float(self.enclosed.gradient(c1) @ d)
        kinetic = 0.5 * float(dv @ (self.M @ dv))
        if acceleration is not None:
            mean = 0.5 * (end.velocity + start.velocity).ravel()[:n]
            force = self.M @ acceleration.ravel()[:n]
            kinetic = float(force @ d) - float(mean @ (self.M @ dv))
        return {"pressure_work": pressure, "load_work": work, "dissipation": kinetic + stored}

    def linearised(self, state: ShellState, dt: float) -> LinearOperator:
        """Inverse of ``M/dt^2 + W'' - p Q''`` under ``Q'(x) = 0``, ``3 n_full`` square."""
        c = state.coefficients.ravel()[: self._n]
        _, tangent = self.shell.gradient_and_tangent(c)
        row = None
        if self.enclosed is not None:
            _, gradient, hessian = self.enclosed.derivatives(c)
            tangent, row = tangent - state.pressure * hessian, self._Es.T @ gradient
        solve = newton.factorize(self._Mr / dt**2 + self._Es.T @ tangent @ self._Es)
        along = None if row is None else solve(row)

        def apply(b: np.ndarray) -> np.ndarray:
            x = solve(self.E.T @ b.ravel())
            if row is not None:
                x = x - along * (row @ x) / (row @ along)
            return self.E @ x

        n = self.E.shape[0]
        return LinearOperator((n, n), matvec=apply, dtype=float)

    def static(
        self,
        coefficients: np.ndarray,
        volume: float | None = None,
        *,
        pressure: float = 0.0,
        load: np.ndarray | Follower | None = None,
    ) -> ShellStep:
        """Static equilibrium near ``coefficients``.

        Parameters
        ----------
        coefficients : (n_full, 3) array
            Start of Newton's iteration.
        volume : float, optional
            Enclosed volume to reach; its multiplier is the excess pressure.
        pressure : float
            Start of the multiplier.
        load : (n_full, 3) array or callable, optional
            Dead load, or ``load(c)`` returning the load on a configuration and its derivative
            ``(3 n_full, 3 n_full)``; see `shells.conditions.loads`.

        Returns
        -------
        ShellStep
            If Newton's iteration fails its state is the start, and residual and outcome tell why.

        Raises
        ------
        ValueError
            Supports that leave a rigid motion free (a mechanism), or a load on supports only.
        """
        self.mechanism.refuse()
        linear = np.zeros(self.E.shape[1])
        follower = load if callable(load) else None
        if load is not None and follower is None:
            linear -= self.E.T @ load.ravel()
            if load.any() and not linear.any():
                raise ValueError("the load acts on supported coefficients only: it moves nothing")
        result = self._solve(
            coefficients, np.zeros_like(linear), pressure, volume, linear, None, follower
        )
        ok = result.outcome is newton.Outcome.CONVERGED
        increment = (self.E @ result.x).reshape(-1, self._d) if ok else np.zeros_like(coefficients)
        new = ShellState(
            0.0,
            coefficients + increment,
            np.zeros_like(increment),
            -result.multiplier if ok else pressure,
        )
        return _step_of(new, result)


def _step_of(state: ShellState, result: newton.NewtonResult) -> ShellStep:
    last = result.history[-1] if result.history else np.inf
    count = len(result.history)
    return ShellStep(state, result.outcome, count, last, result.residual, result.factorizations)
