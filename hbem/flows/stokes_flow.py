"""Stokes flow about closed surfaces of given velocity: the library's front door.

``V tau = (1 + lambda)/2 u + (1 - lambda) K u - lambda u_inf`` [T 5.4], ``<tau, n> = 0`` on each
closed component: tau is the traction jump across the surfaces, lambda the outer over the inner
viscosity, u_inf the undisturbed outer flow. For lambda = 1 this is ``V tau = u - u_inf``, without
K. For rigid motions the fluid inside is at rest in the body's frame and tau is the outer traction,
up to a constant pressure.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..accuracy import COMPRESSION, Budget, larger_unknowns
from ..layers.choice import STORED_LIMIT
from ..layers.single_layer import single_layer_on
from ..near.facing_gap import closest_facing
from ..solvers.saddle import DENSE_LIMIT
from ..solvers.saddle_system import MassPreconditioner
from ..solvers.schwarz import two_level_schwarz
from ..surfaces.patches import BezierPatches, SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface, sample
from ..surfaces.topology import closed_components
from ..traction_error import TractionError, Verdict
from .admissible import check_bodies, check_viscosities, velocities
from .formulation import JumpFormulation
from .measured_solve import Measured, MeasuredSolve
from .mesh_share import RESOLVED, LargerSpace, film_advice, film_ratio, resampled
from .surface_traction import SurfaceTraction, with_flux_judged
from .tolerances import TIGHTER, flow_budget, flow_compression, flow_orders

logger = logging.getLogger(__name__)
FIRST_SOLVE = 1e-3  # relative residual of a solve that is corrected
MEASURES = ("auto", "all", "operator", "none")
TIGHTENED = 4  # compressions tried, each ten times sharper than the one before
LARGER_LIMIT = 12_000  # unknowns of the larger space up to which the mesh's share costs little
Velocity = Callable[[np.ndarray], np.ndarray] | np.ndarray


class StokesFlow:
    """Stokes flow on one configuration of closed surfaces.

    Parameters
    ----------
    patches : SurfacePatches
        One or several closed surfaces, normals ``x_s x x_t`` outward.
    coefficients : (n_coefficients, 3) array, optional
        Configuration; default that of the patches.
    tolerance : float
        Relative traction error in the L2 norm. Quadrature, compression and Krylov iteration are
        driven below it; the mesh is the caller's, and its share is measured. Every traction
        tells all three and the verdict in its ``error``; what is missed is logged.
    viscosity : float
        Of the fluid inside.
    viscosity_ratio : float
        Outer over inner viscosity: 0 is the flow inside alone, without an outer fluid.
    background : callable or (3,) array, optional
        Undisturbed velocity of the outer fluid at points ``(n, 3)``; itself a Stokes flow.
    orders : QuadratureOrders, optional
        Overrides those that follow from the tolerance.
    compression : {"auto", "dense", "aca", "h2"}
        Of the single layer. ``auto`` stores up to 6000 unknowns densely and takes the cheapest of
        direct sums, ACA and H2 beyond; ``dense`` never compresses. The double layer of unequal
        viscosities is always summed directly.
    measure : {"auto", "all", "operator", "none"}
        Which errors are measured in every solve. ``operator``: quadrature, compression and Krylov
        iteration, and corrected until the tolerance is met; it costs a near field of its own,
        about the time of the first. ``all``: that of the mesh too, by a larger density space,
        which takes some four times as long as the solve. ``auto``: that where it has up to 12 000
        unknowns. What is not measured has no figure, and the verdict is "cannot tell" at best.

    Attributes
    ----------
    points, normals, weights : (n_points, 3), (n_points, 3), (n_points,) array
        Quadrature points, where velocities are wanted and tractions given.
    components : (n_dofs,) int array
        Closed component of each density function.
    budget : Budget
        Tolerances that follow from ``tolerance`` and the narrowest gap.
    facing : FacingGap or None
        Closest points of facing walls.
    compression : Compression or None
        What was chosen; None for a dense matrix or direct sums.

    Raises
    ------
    SurfaceError
        An open surface, elements given twice, mixed orientation, inward normals, bodies that cross
        or touch, or nested ones with a viscosity ratio that leaves no viscosity inside both.
    ValueError
        A viscosity that is not positive, a negative ratio, a background without outer fluid,
        coefficients of the wrong shape, not finite or beyond double precision's reach, or a word
        that is none for compression or measure.
    """

    def __init__(
        self,
        patches: SurfacePatches,
        coefficients: np.ndarray | None = None,
        *,
        tolerance: float = 1e-3,
        viscosity: float = 1.0,
        viscosity_ratio: float = 1.0,
        background: Velocity | None = None,
        orders: QuadratureOrders | None = None,
        compression: str = "auto",
        measure: str = "auto",
    ):
        if measure not in MEASURES:
            raise ValueError(f"measure must be one of {MEASURES}, got {measure!r}")
        check_viscosities(viscosity, viscosity_ratio, background=background is not None)
        if background is not None and not callable(background) and np.shape(background) != (3,):
            raise ValueError(
                f"background: expected a callable or 3 numbers, got shape {np.shape(background)}"
            )
        self.viscosity_ratio, self.background = viscosity_ratio, background
        if coefficients is None:
            coefficients = patches.coefficients if isinstance(patches, BezierPatches) else None
            if coefficients is None:
                raise ValueError("these patches carry no configuration: give coefficients")
        self.patches, self.coefficients, self.viscosity = patches, coefficients, viscosity
        self.components = closed_components(patches, coefficients)
        sampled = sample(patches, coefficients, QuadratureOrders())
        check_bodies(sampled, self.components, viscosity_ratio)
        self.facing = closest_facing(sampled)
        self.budget: Budget = flow_budget(sampled, self.facing, tolerance)
        if measure == "none":
            for warning in self.budget.warnings:
                logger.warning(warning)
        self.orders = flow_orders(self.budget, compression) if orders is None else orders
        self._measured = measure != "none"
        larger = larger_unknowns(patches.n_elements, patches.density_degree, patches.shape)
        self._mesh_measured = measure == "all" or (measure == "auto" and larger <= LARGER_LIMIT)
        asked = compression, self.budget, patches, self.orders, self._measured
        self.compression = flow_compression(*asked)

    def __repr__(self) -> str:
        n, chosen = 3 * self.patches.n_dofs, self.compression
        layer = "dense matrix" if n <= STORED_LIMIT else "direct sums"
        if chosen is not None:
            layer = f"{chosen.method} at {chosen.tolerance:.1e}"
        lu = chosen is None and n <= DENSE_LIMIT
        solver = "LU" if lu else f"GMRES ({self.budget.preconditioner})"
        bodies = f"closed surfaces: {self.components.max() + 1}"
        return f"StokesFlow({n} unknowns, {bodies}, {layer}, {solver})"

    @cached_property
    def surface(self) -> SampledSurface:
        """Points alone; the operator is built at the first solve."""
        return sample(self.patches, self.coefficients, self.orders)

    @cached_property
    def formulation(self) -> JumpFormulation:
        """Operators and linear system, built when first asked for."""
        schwarz = self.budget.preconditioner == "schwarz"
        return JumpFormulation(
            single_layer_on(self.surface, self.orders, compression=self.compression),
            self.viscosity_ratio,
            self.orders,
            # what the first iteration leaves, the corrections find and remove
            max(self.budget.krylov, FIRST_SOLVE) if self._measured else self.budget.krylov,
            two_level_schwarz if schwarz else MassPreconditioner,
            components=self.components,
        )

    @cached_property
    def solver(self) -> MeasuredSolve:
        """The formulation and the sharper ones that measure it."""
        return MeasuredSolve(self.formulation, self.budget.traction)

    @cached_property
    def larger(self) -> LargerSpace:
        """The larger density space that measures the mesh's share."""
        finest = self.solver.finest if self._measured else self.formulation
        fat = self.budget.preconditioner == "mass"
        return LargerSpace(finest, self.formulation.system, fat, self.budget.thinness)

    @property
    def points(self) -> np.ndarray:
        """Quadrature points, ``(n_points, 3)``."""
        return self.surface.outer.points

    @property
    def normals(self) -> np.ndarray:
        """Outward unit normals there, ``(n_points, 3)``."""
        return self.surface.outer.normals

    @property
    def weights(self) -> np.ndarray:
        """Quadrature weights, surface element included, ``(n_points,)``."""
        return self.surface.outer.weights

    def traction(self, velocity: Velocity) -> SurfaceTraction:
        """Solve for the traction of a boundary velocity.

        Parameters
        ----------
        velocity : callable, (n_points, 3) array or (3,) array
            A callable receives points ``(n, 3)``; arrays belong to `points`. A net flux out of
            a component cannot be: the fluid is incompressible, the solution then leaks it.

        Returns
        -------
        SurfaceTraction
            Its ``result`` is ``NET_FLUX`` if a component's flux exceeds the tolerance.

        Raises
        ------
        ValueError
            A velocity of the wrong shape, complex or not finite.
        """
        u = _at(velocity, self.points)
        measured = self._solve(u)
        found, error = measured.solved, self._error(measured, velocity, u)
        if not found.result.ok:
            logger.warning("%s (residual %.1e)", found.result.value, found.residual)
        if error.verdict is Verdict.MISSED or not error.resolved:
            logger.warning("traction error %s", error)
        traction = SurfaceTraction(
            self.viscosity * found.solution.reshape(-1, 3),
            self.viscosity * np.atleast_1d(found.zeta),
            found.result,
            found.iterations,
            found.residual,
            error,
            u,
            self.formulation,
            self.viscosity,
            None if self.background is None else self.undisturbed,
        )
        return with_flux_judged(traction, self.budget.traction)

    def _solve(self, u: np.ndarray) -> Measured:
        """Solution; a compression that corrections do not cure is built ten times more sharply."""
        on, tested = self._measured, self._tested(u)
        for left in reversed(range(TIGHTENED)):
            measured = self.solver.solve(*tested, compression=on, quadrature=False)
            error = self.solver.error(measured, 0.0)
            if not (left and error.compression > COMPRESSION * self.budget.traction):
                break
            assert self.compression is not None  # its error is not zero
            finer = TIGHTER * self.compression.tolerance
            logger.info("compression at %.1e instead of %.1e", finer, self.compression.tolerance)
            self.compression = replace(self.compression, tolerance=finer)
            for name in ("formulation", "solver", "larger"):
                self.__dict__.pop(name, None)
        return self.solver.refined(measured, *tested) if on else measured

    def _error(self, measured: Measured, velocity: Velocity, u: np.ndarray) -> TractionError:
        """All shares of the error of a solve, for the velocity as given and at the points."""
        solved, tolerance = measured.solved, self.budget.traction
        error = self.solver.error(measured, self.budget.krylov_error(solved.residual))
        if film_ratio(self.facing) > RESOLVED:
            assert self.facing is not None
            error = replace(error, resolved=False, advice=film_advice(self.facing))
        if not self._mesh_measured:
            return error
        outer = self.larger.formulation.surface.outer
        at = _at(velocity, outer.points) if callable(velocity) else None
        at = resampled(u, self.surface.outer, outer) if at is None else at
        undisturbed = None if self.background is None else self.undisturbed(outer.points)
        share = self.larger.share(solved.solution, solved.zeta, at, undisturbed)
        advice = error.advice or share.advice(self.surface, tolerance)
        return replace(error, mesh=share.error, advice=advice)

    def undisturbed(self, points: np.ndarray) -> np.ndarray:
        """Background velocity at points.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        (n, 3) array
        """
        if self.background is None:
            return np.zeros(points.shape)
        return _at(self.background, points, "background")

    def _tested(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray | float]:
        """Tested velocities at the points and of the background, ``(3 n_dofs,)`` each."""
        project = self.surface.project
        tested = project(u).ravel()
        if self.background is None:
            return tested, 0.0
        return tested, project(self.undisturbed(self.points)).ravel()


def _at(velocity: Velocity, points: np.ndarray, name: str = "velocity") -> np.ndarray:
    """Checked velocities at points."""
    return velocities(name, velocity(points) if callable(velocity) else velocity, points)
