"""The mesh's share of a traction error, by a hierarchical estimate.

The density is sought in a larger space on the same elements: the polynomials of each by itself,
with no continuity between them. What the larger space adds to a solution is its discretisation
error, but for what the larger space still misses: between 0.9 and 1.1 of it where the mesh
resolves the flow, and far above 1 in gaps that it does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from ..layers.choice import choose
from ..layers.single_layer import single_layer_on
from ..solvers.refinement import INNER
from ..solvers.saddle import DENSE_LIMIT
from ..solvers.saddle_system import Builder
from ..surfaces.bernstein import tensor_bernstein
from ..surfaces.patches import BezierPatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import PointSet, SampledSurface, point_set
from .formulation import JumpFormulation

MATRIX = 1e-4  # compression of the larger operator: enough for one digit of its correction


@dataclass(frozen=True)
class MeshShare:
    """Discretisation error of one element after the other.

    Attributes
    ----------
    error : float
        L2 norm of what the larger space adds, over that of the traction.
    elements : (n_elements,) array
        The same of each element: their squares add up.
    iterations : int
        Of its linear solve.
    """

    error: float
    elements: np.ndarray
    iterations: int

    @property
    def worst(self) -> int:
        """Element with the largest share."""
        return int(np.argmax(self.elements))


def mesh_share(
    formulation: JumpFormulation,
    density: np.ndarray,
    zeta: np.ndarray | float,
    velocity: Callable[[PointSet], np.ndarray],
    background: Callable[[PointSet], np.ndarray] | None,
    preconditioner: Builder,
) -> MeshShare:
    """Estimate the discretisation error of a solution.

    Parameters
    ----------
    formulation : JumpFormulation
        With the orders that the solution was corrected to.
    density : (3 n_dofs,) array
        Solution, in units of the interior viscosity.
    zeta : float or (n_components,) array
        Its multipliers.
    velocity, background : callable
        Boundary and undisturbed velocity at points of the surface, ``(n_points, 3)``.
    preconditioner : callable
        Of GMRES in the larger space, where LU is too dear.

    Returns
    -------
    MeshShare
    """
    larger = _larger(formulation, preconditioner)
    surface = larger.surface
    start = injection(formulation.surface.patches, surface.patches.density_degree)
    injected = (start @ density.reshape(-1, 3)).ravel()
    tested = surface.project(velocity(surface.outer)).ravel()
    undisturbed: np.ndarray | float = 0.0
    if background is not None:
        undisturbed = surface.project(background(surface.outer)).ravel()
    system = larger.system
    residual = larger.data(tested, undisturbed) - larger.layer @ injected
    residual = residual - system.system.multiplied(zeta)
    found = system.correction(residual, injected, INNER)
    d = found.solution.reshape(-1, 3)
    own = np.sum(surface.basis @ injected.reshape(-1, 3) * 1.0, axis=1) if False else None
    values = surface.basis @ d
    squares = np.sum(values * values, axis=1) * surface.outer.weights
    squares = squares.reshape(surface.patches.n_elements, -1).sum(axis=1)
    t = surface.basis @ injected.reshape(-1, 3)
    size = np.sqrt(np.sum(t * t, axis=1) @ surface.outer.weights)
    parts = np.sqrt(squares) / max(size, 1e-300)
    return MeshShare(float(np.sqrt(np.sum(parts**2))), parts, found.iterations)


def _larger(made: JumpFormulation, preconditioner: Builder) -> JumpFormulation:
    """The same formulation with the polynomials of each element by itself as densities."""
    base, degree = made.surface, made.surface.patches.density_degree
    patches = broken(base.patches, degree)
    orders = replace(made.orders, outer=max(made.orders.outer, degree + 1), far=made.orders.source)
    surface = replace(base, patches=patches)
    if orders.outer != made.orders.outer:
        surface = replace(surface, outer=point_set(base.control, orders.outer))
        surface = surface.with_source(orders)
    compression = choose(
        "auto",
        {"h2": MATRIX},
        n_dofs=patches.n_dofs,
        n_outer=surface.outer.weights.size,
        n_source=surface.source.weights.size,
        products=20,
    )
    layer = single_layer_on(surface, orders, compression=compression)
    components = made.components
    if components is not None:
        first = base.patches.dofs[base.patches.indptr[:-1]]
        components = np.repeat(components[first], (degree + 1) ** 2)
    return replace(
        made,
        layer=layer,
        orders=orders,
        preconditioner=preconditioner,
        dense_limit=DENSE_LIMIT,
        components=components,
    )


def broken(patches: BezierPatches, degree: int) -> BezierPatches:
    """The same elements with all polynomials of a degree on each, discontinuous."""
    n, count = patches.n_elements, (degree + 1) ** 2
    return BezierPatches(
        n * count,
        patches.geometry_degree,
        degree,
        count * np.arange(n + 1),
        np.arange(n * count),
        np.tile(np.eye(count), (n, 1)),
        patches.bezier,
    )


def injection(patches: BezierPatches, degree: int) -> csr_matrix:
    """Densities of a surface as discontinuous polynomials, ``(n_elements (p + 1)^2, n_dofs)``."""
    count = (degree + 1) ** 2
    element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
    rows = element[:, None] * count + np.arange(count)
    columns = np.broadcast_to(patches.dofs[:, None], rows.shape)
    shape = (patches.n_elements * count, patches.n_dofs)
    return csr_matrix((patches.extraction.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
