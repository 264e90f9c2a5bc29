"""The mesh's share of a traction error, by a hierarchical estimate.

The density is sought in a larger space on the same elements: the polynomials of each by itself,
with no continuity between them; on triangles of one degree more. What the larger space adds to a
solution is its discretisation error, but for what the larger space still misses: 0.89 to 1.19 of it
on spheres and spheroids (`airfold bench honesty`), 0.97 to 1.04 with linear densities on raw
triangles (`airfold bench meshes`), and far above 1 in gaps that the mesh does not resolve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ..accuracy import AMPLIFICATION
from ..layers.choice import choose
from ..layers.single_layer import single_layer_on
from ..near.facing_gap import FacingGap
from ..solvers.nested import NestedSchwarz, nested_schwarz
from ..solvers.refinement import INNER
from ..solvers.saddle import DENSE_LIMIT, DenseSaddle, IterativeSaddle
from ..solvers.saddle_system import MassPreconditioner, SaddleSystem
from ..surfaces.bernstein import bernstein, tensor_bernstein
from ..surfaces.patches import BezierPatches
from ..surfaces.surface_points import PointSet, SampledSurface
from ..surfaces.triangles import collapse_table
from .formulation import JumpFormulation

THIN = 0.05  # thinness from which on the size of a correction needs a smaller residual
MATRIX = 1e-4  # compression of the larger operator: enough for one digit of its correction
PRODUCTS = 20  # with it, preconditioner included
RESOLVED = 2.0  # film lengths an element may have where the estimate still serves
RESOLVING = 0.7  # film lengths an element has where it resolves the film


def film_ratio(gap: FacingGap | None) -> float:
    """Element size over the length of the film in a gap; 0 where no walls face each other."""
    if gap is None or not np.isfinite(gap.film_length):
        return 0.0
    return float(gap.element_size.max() / max(gap.film_length, 1e-300))


def film_advice(gap: FacingGap) -> str:
    """Where a mesh is too coarse for the film in a gap, and what would do."""
    a, b = gap.elements
    return (
        f"elements {a} and {b} near {_place(gap.points.mean(axis=0))} are {film_ratio(gap):.2g} "
        f"film lengths sqrt(gap R) = {gap.film_length:.2g} long at a gap of {gap.distance:.2g}: "
        f"refine them there to {RESOLVING * gap.film_length:.2g}"
    )


@dataclass(frozen=True)
class MeshShare:
    """Discretisation error of a solution.

    Attributes
    ----------
    error : float
        L2 norm of what the larger space adds, over that of the traction.
    elements : (n_elements,) array
        The same of each element; their squares add up to that of ``error``.
    iterations : int
        Of the linear solve.
    """

    error: float
    elements: np.ndarray
    iterations: int

    def advice(self, surface: SampledSurface, tolerance: float) -> str:
        """Where the share is largest and what refinement would do; empty within the tolerance.

        Errors of degree p go with the power p + 1 of the size of elements.
        """
        if self.error <= tolerance:
            return ""
        e = int(np.argmax(self.elements))
        times = (self.error / tolerance) ** (1.0 / (surface.patches.density_degree + 1))
        return (
            f"the mesh's share is largest on element {e} near "
            f"{_place(surface.centres[e] + surface.outer.origin)}: elements about {times:.1f} "
            "times smaller there would meet the tolerance"
        )


@dataclass(frozen=True)
class LargerSpace:
    """A formulation with the polynomials of each element by itself as densities.

    Parameters
    ----------
    base : JumpFormulation
        With the orders that its solutions were corrected to.
    solver : DenseSaddle or IterativeSaddle
        That the solutions come from; the coarse level of GMRES in the larger space.
    fat : bool
        No gap asks for more than the mass matrix as a preconditioner.
    thinness : float
        Of the narrowest gap, which amplifies what the iteration leaves.
    """

    base: JumpFormulation
    solver: DenseSaddle | IterativeSaddle
    fat: bool
    thinness: float = np.inf

    @cached_property
    def formulation(self) -> JumpFormulation:
        """Operators and linear system of the larger space."""
        made = self.base
        patches = made.surface.patches
        larger = broken(made.surface)
        degree = larger.density_degree
        orders = replace(
            made.orders, outer=max(made.orders.outer, degree + 1), far=made.orders.source
        )
        surface = replace(made.surface, patches=larger).with_points(orders)
        compression = choose(
            "auto",
            {"h2": MATRIX},
            n_dofs=surface.patches.n_dofs,
            n_outer=surface.outer.weights.size,
            n_source=surface.source.weights.size,
            products=PRODUCTS,
        )
        components = made.components
        if components is not None:
            first = components[patches.dofs[patches.indptr[:-1]]]
            components = np.repeat(first, surface.patches.n_dofs // patches.n_elements)
        return replace(
            made,
            layer=single_layer_on(surface, orders, compression=compression),
            orders=orders,
            preconditioner=MassPreconditioner if self.fat else self._nested,
            dense_limit=DENSE_LIMIT,
            components=components,
        )

    def _nested(self, system: SaddleSystem) -> NestedSchwarz:
        return nested_schwarz(system, self.solver, self.injection)

    @cached_property
    def injection(self) -> csr_matrix:
        """Densities of the base in the larger space, ``(n_larger, n_dofs)``."""
        patches, (degree, table) = self.base.surface.patches, _polynomials(self.base.surface)
        raised = _raised(patches.density_degree, degree)
        local, count = patches.extraction @ raised @ np.linalg.pinv(table), table.shape[0]
        element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
        rows = element[:, None] * count + np.arange(count)
        columns = np.broadcast_to(patches.dofs[:, None], rows.shape)
        shape = (patches.n_elements * count, patches.n_dofs)
        entries = (local.ravel(), (rows.ravel(), columns.ravel()))
        return csr_matrix(entries, shape=shape)

    def share(
        self,
        density: np.ndarray,
        zeta: np.ndarray | float,
        velocity: np.ndarray,
        background: np.ndarray | None = None,
    ) -> MeshShare:
        """Estimate the discretisation error of a solution of the base.

        Parameters
        ----------
        density : (3 n_dofs,) array
            Per interior viscosity.
        zeta : float or (n_components,) array
            Its multipliers.
        velocity, background : (n_points, 3) array
            Boundary and undisturbed velocity at the outer points of the larger formulation.

        Returns
        -------
        MeshShare
        """
        made = self.formulation
        surface, system = made.surface, made.system
        start = self.injection @ density.reshape(-1, 3)
        tested = surface.project(velocity).ravel()
        undisturbed = 0.0 if background is None else surface.project(background).ravel()
        residual = made.data(tested, undisturbed) - made.layer @ start.ravel()
        residual -= system.system.multiplied(zeta)
        left = INNER * min(1.0, self.thinness / THIN) ** AMPLIFICATION
        found = system.correction(residual, start.ravel(), left)
        weights = surface.outer.weights

        def squares(values: np.ndarray) -> np.ndarray:
            at = surface.basis @ values
            per_point = np.sum(at * at, axis=1) * weights
            return per_point.reshape(surface.patches.n_elements, -1).sum(axis=1)

        size = max(float(np.sqrt(squares(start).sum())), 1e-300)
        elements = np.sqrt(squares(found.solution.reshape(-1, 3))) / size
        return MeshShare(float(np.linalg.norm(elements)), elements, found.iterations)


def resampled(values: np.ndarray, old: PointSet, new: PointSet) -> np.ndarray:
    """Values ``(n_points, 3)`` at other points of the same elements, by interpolation on each."""
    if old.per_element == new.per_element:
        return values
    degree = round(old.per_element**0.5) - 1
    table = tensor_bernstein(degree, new.s, new.t) @ np.linalg.inv(
        tensor_bernstein(degree, old.s, old.t)
    )
    return (table @ values.reshape(-1, old.per_element, 3)).reshape(-1, 3)


def _place(point: np.ndarray) -> str:
    small = 1e-9 * np.abs(point).max()
    return "(" + ", ".join(f"{x if abs(x) > small else 0.0:.3g}" for x in point) + ")"


def broken(surface: SampledSurface) -> BezierPatches:
    """The same elements with all polynomials of a degree on each, discontinuous."""
    patches, (degree, table) = surface.patches, _polynomials(surface)
    n, count = patches.n_elements, table.shape[0]
    return BezierPatches(
        n * count,
        patches.geometry_degree,
        degree,
        count * np.arange(n + 1),
        np.arange(n * count),
        np.tile(table, (n, 1)),
        patches.bezier,
    )


def _polynomials(surface: SampledSurface) -> tuple[int, np.ndarray]:
    """Degree of the larger space and its functions on an element, as tensor Bernstein rows.

    Of quadrilaterals the density's own, of triangles one more: continuous functions of degree p on
    triangles leave too little to discontinuous ones of the same degree. What a contracted square
    has beyond a triangle's polynomials is no function at its vertex, and the near rules, which
    contract other vertices too, do not know it.
    """
    degree = surface.patches.density_degree
    if surface.triangular:
        return degree + 1, collapse_table(degree + 1).T
    return degree, np.eye((degree + 1) ** 2)


def _raised(low: int, high: int) -> np.ndarray:
    """Tensor Bernstein coefficients of a degree to those of a higher one, from the right."""
    x = np.arange(high + 1) / high
    line = np.linalg.solve(bernstein(high, x), bernstein(low, x)).T
    return np.kron(line, line)
