"""An enclosed flow on one frozen configuration: tractions, loads, and the response.

``R v = -m Psi^T W B S^-1 B^T W (Psi + inlet) v`` (lambda = 1) maps the membrane's velocity to the
load on it; Psi evaluates velocities at the outer points, S is the saddle system of V [T 5.4].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import LinearOperator

from ..layers.layer import SingleLayer
from ..solvers.saddle import DenseSaddle
from ..solvers.saddle_system import SaddleSolution
from ..surfaces.configuration import real_array
from ..surfaces.surface_points import SampledSurface, geometry_matrix
from ..traction import Traction
from ..traction_error import TractionError
from .admissible import velocities
from .enclosed_problem import EnclosedProblem
from .formulation import JumpFormulation
from .measured_solve import MeasuredSolve
from .mesh_share import LargerSpace


@dataclass(frozen=True)
class EnclosedOperator:
    """The flow on one frozen configuration; made by `hbem.EnclosedStokes.assemble`.

    Parameters
    ----------
    problem : EnclosedProblem
    formulation : JumpFormulation
    on_solve : callable
        Receives the `SaddleSolution` of every traction.
    tolerance : float
        Error asked of the traction, which measured errors are compared with.
    fat : bool
        No gap asks for more than the mass matrix as a preconditioner.
    """

    problem: EnclosedProblem
    formulation: JumpFormulation
    on_solve: Callable[[SaddleSolution], None]
    tolerance: float = np.inf
    fat: bool = True

    @property
    def layer(self) -> SingleLayer:
        return self.formulation.layer

    @property
    def surface(self) -> SampledSurface:
        return self.formulation.surface

    @cached_property
    def _on_inlet(self) -> np.ndarray:
        return np.repeat(self.problem.inflow, self.surface.outer.per_element)

    @cached_property
    def evaluation(self) -> csr_matrix:
        """Psi: coefficients to values at outer points, zero on the inlet."""
        full = geometry_matrix(self.problem.patches, self.surface.outer)
        return (diags(1.0 - self._on_inlet) @ full).tocsr()

    @cached_property
    def coupling(self) -> csr_matrix:
        """``B^T W Psi``: coefficients to tested values, scalar ``(n_dofs, n_coefficients)``."""
        outer = self.surface.outer
        return (self.surface.basis.T @ diags(outer.weights) @ self.evaluation).tocsr()

    @cached_property
    def flux_form(self) -> np.ndarray:
        """The flux as a linear form of the velocity, ``(n_coefficients, 3)``."""
        outer = self.surface.outer
        return self.evaluation.T @ (outer.weights[:, None] * outer.normals)

    @cached_property
    def _unit_influx(self) -> np.ndarray:
        """Data on the inlet for unit influx, at the outer points ``(n_points, 3)``."""
        outer, inside = self.surface.outer, self._on_inlet
        values = np.zeros_like(outer.points)
        if self.problem.profile is None:
            return values
        profile = real_array("inflow profile", self.problem.profile(outer.points[inside]))
        total = outer.weights[inside] @ profile
        if not total > 0.0:
            raise ValueError(f"the inflow profile integrates to {total:.3g}, expected > 0")
        values[inside] = -profile[:, None] * outer.normals[inside] / total
        return values

    @cached_property
    def influx_data(self) -> np.ndarray:
        """Tested velocity of a unit influx, ``(n_dofs, 3)``."""
        return self.surface.project(self._unit_influx)

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of ``velocity (n_coefficients, 3)`` out through the membrane."""
        return float(np.sum(self.flux_form * velocity))

    def boundary_velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Dirichlet data at the outer points, ``(n_points, 3)``."""
        return self.evaluation @ velocity + self.flux(velocity) * self._unit_influx

    def traction(self, velocity: np.ndarray) -> Traction:
        """Traction jump for membrane velocity ``(n_coefficients, 3)``.

        Raises
        ------
        ValueError
            A velocity of the wrong shape, complex or not finite.
        """
        expected = (self.problem.patches.n_coefficients, 3)
        velocity = real_array("velocity", velocity)
        if velocity.shape != expected:
            raise ValueError(f"expected velocity {expected}, got {velocity.shape}")
        solved = self.solve(self.linear_data(velocity) - self._background_data)
        return Traction(
            solved.solution.reshape(-1, 3),
            float(solved.zeta),
            self.flux(velocity),
            float(np.linalg.norm(self.boundary_velocity(velocity), axis=1).max()),
            iterations=solved.iterations,
            residual=solved.residual,
            measure=partial(self._measure, velocity, solved),
        )

    def _measure(
        self,
        velocity: np.ndarray,
        solved: SaddleSolution,
        krylov: float,
        quadrature: bool,
        mesh: bool,
    ) -> TractionError:
        """Estimated error of a traction, see `Traction.measure`; nothing is corrected.

        The structure was solved with this operator, so its error is that of the step.
        """
        made = self.formulation
        solver = MeasuredSolve(made, self.tolerance)
        tested = self._tested(velocity).ravel()
        background: np.ndarray | float = 0.0
        if self.problem.background is not None:
            background = self._background_data / self.problem.viscosity_ratio
        measured = solver.decompressed(solved, tested, background)
        if quadrature:
            measured = solver.refined(measured, tested, background, rules=1)
        error = solver.error(measured, krylov, corrected=False)
        if not mesh:
            return error
        larger = LargerSpace(solver.finest, made.system, self.fat)
        there = EnclosedOperator(self.problem, larger.formulation, self.on_solve)
        undisturbed = None
        if self.problem.background is not None:
            undisturbed = self.problem.background(there.surface.outer.points)
        share = larger.share(
            measured.solved.solution,
            measured.solved.zeta,
            there.boundary_velocity(velocity),
            undisturbed,
        )
        advice = share.advice(self.surface, self.tolerance)
        return replace(error, mesh=share.error, elements=share.elements, advice=advice)

    def _tested(self, velocity: np.ndarray) -> np.ndarray:
        """Tested boundary velocity, ``(n_dofs, 3)``."""
        return self.coupling @ velocity + self.flux(velocity) * self.influx_data

    def linear_data(self, velocity: np.ndarray) -> np.ndarray:
        """Right-hand side without background, ``(3 n_dofs,)``."""
        return self.formulation.data(self._tested(velocity).ravel())

    @cached_property
    def _background_data(self) -> np.ndarray:
        """Tested ``lambda u_inf``, ``(3 n_dofs,)``."""
        problem = self.problem
        if problem.background is None:
            return np.zeros(3 * problem.patches.n_dofs)
        points = self.surface.outer.points
        velocity = velocities("background", problem.background(points), points)
        return problem.viscosity_ratio * self.surface.project(velocity).ravel()

    def solve(self, data: np.ndarray) -> SaddleSolution:
        """Traction jump for a right-hand side ``(3 n_dofs,)``."""
        solved = self.formulation.system.solve(data)
        self.on_solve(solved)
        return solved

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """``-m <tau, rho>`` of a traction's coefficients ``(n_dofs, 3)``."""
        return -self.problem.mass_ratio * (self.coupling.T @ coefficients)

    def load(self, traction: Traction) -> np.ndarray:
        """Force ``-m <tau, rho>`` on the membrane, ``(n_coefficients, 3)``."""
        return self.force(traction.coefficients)

    def drive(self) -> np.ndarray | None:
        """Load of the background on the membrane at rest; None without background."""
        if self.problem.background is None:
            return None
        return self.force(self.solve(-self._background_data).solution.reshape(-1, 3))

    def response(self) -> Response:
        """Velocity to load, ``3 n_coefficients`` square; with a ``dense()`` where LU solves."""
        direct = isinstance(self.formulation.system, DenseSaddle)
        return DirectResponse(self) if direct else Response(self)


class Response(LinearOperator):
    """The linear map ``load = R v`` (plus the drive) on interleaved coefficients ``3 a + i``."""

    def __init__(self, operator: EnclosedOperator):
        n = 3 * operator.problem.patches.n_coefficients
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self._operator = operator

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        op = self._operator
        traction = self._traction(op.linear_data(np.asarray(x).reshape(-1, 3)))
        return op.force(traction.reshape(-1, 3)).ravel()

    def _traction(self, data: np.ndarray) -> np.ndarray:
        return self._operator.solve(data).solution


class DirectResponse(Response):
    """The response by LU factors: solves need no residual, and may be many."""

    def _traction(self, data: np.ndarray) -> np.ndarray:
        system = self._operator.formulation.system
        assert isinstance(system, DenseSaddle)
        return system.density(data)

    def dense(self) -> np.ndarray:
        """R as an array: one factorisation, one right-hand side a membrane velocity dof."""
        op = self._operator
        matrix = np.zeros(self.shape)
        moving = np.flatnonzero(np.diff(op.coupling.tocsc().indptr))
        columns = (3 * moving[:, None] + np.arange(3)).ravel()
        coupling = op.coupling[:, moving].toarray()
        data = np.einsum("ab,ik->aibk", coupling, np.eye(3)).reshape(-1, columns.size)
        influx = np.outer(op.influx_data.ravel(), op.flux_form[moving].ravel())
        tractions = self._traction(op.formulation.data(data + influx))
        tractions = tractions.reshape(coupling.shape[0], -1)
        load = -op.problem.mass_ratio * (coupling.T @ tractions)
        matrix[np.ix_(columns, columns)] = load.reshape(columns.size, columns.size)
        return matrix
