"""A surface at its quadrature points: geometry and density functions, ready for the kernels.

Everything that depends on the configuration alone and not on a kernel: points, weights
``w |x_s x x_t|``, normals, the evaluation matrix B, the mass matrix ``B^T W B`` and the
constraint ``c_a = int N_a n``. Both sides of an equation must use the same outer points.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from .bernstein import centred_powers, tensor_bernstein, tensor_bernstein_gradient
from .configuration import centred_control, edge_lengths, shortest_edge
from .patches import SurfacePatches
from .quadrature import QuadratureOrders, gauss_square
from .subdivision import ElementPieces, balls, divide, grid_points
from .triangles import quadrilaterals, rotation_table


@dataclass(frozen=True)
class PointSet:
    """Tensor Gauss points of every element, ``per_element`` each.

    Attributes
    ----------
    s, t : (per_element,) array
        Local coordinates.
    offsets, normals : (n, 3) array
        Positions relative to `origin`, and outward unit normals. Integrals between points need
        these: far from the origin of coordinates differences of positions are mere rounding.
    weights : (n,) array
        Quadrature weights including the surface element.
    origin : (3,) array
    """

    s: np.ndarray
    t: np.ndarray
    offsets: np.ndarray
    normals: np.ndarray
    weights: np.ndarray
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @cached_property
    def points(self) -> np.ndarray:
        """Positions, ``(n, 3)``."""
        return self.offsets + self.origin if np.any(self.origin) else self.offsets

    @property
    def per_element(self) -> int:
        return self.s.size


@dataclass(frozen=True)
class PatchShapes:
    """Tensor patches of all elements in one contraction, and nothing that belongs to another.

    Parameters
    ----------
    control : (n_elements, degree + 1, degree + 1, 3) array
        Bezier control points.
    """

    control: np.ndarray

    @cached_property
    def power_coefficients(self) -> np.ndarray:
        """Patches in powers of ``2 s - 1``, ``2 t - 1``: ``(n_elements, 3, degree + 1, ..)``."""
        degree = self.control.shape[1] - 1
        power = centred_powers(degree)
        shapes = np.einsum("ki,eijc,lj->eckl", power, self.control, power, optimize=True)
        return np.ascontiguousarray(shapes)

    @property
    def powers(self) -> tuple[float, ...]:
        """As many entries as there are powers: a length that compiled code knows beforehand."""
        return (0.0,) * self.control.shape[1]


@dataclass(frozen=True)
class SampledSurface:
    """One configuration of a surface, sampled.

    Parameters
    ----------
    patches : SurfacePatches
    control : (n_elements, geometry_degree + 1, geometry_degree + 1, 3) array
        Bezier control points relative to `origin`.
    outer, source : PointSet
        Outer (test) points and plain source points; often the same object.
    centres : (n_elements, 3) array
    radii : (n_elements,) array
        Balls around the elements, relative to `origin` as well.
    collapsed : (n_elements,) bool array
        Elements with an edge contracted to a point.
    triangular : bool
        Whether all elements are triangles, contracted at their vertex 0.
    """

    patches: SurfacePatches
    control: np.ndarray
    outer: PointSet
    source: PointSet
    centres: np.ndarray
    radii: np.ndarray
    collapsed: np.ndarray
    triangular: bool = False

    @property
    def origin(self) -> np.ndarray:
        """Where all relative positions count from, ``(3,)``; see `centred_control`."""
        return self.outer.origin

    @cached_property
    def pieces(self) -> ElementPieces:
        """Pieces of elements for the near rules; whole elements unless they turn a lot."""
        return divide(self.control)

    @cached_property
    def shapes(self) -> PatchShapes:
        """The patches as the near rules take them."""
        return PatchShapes(self.control)

    @cached_property
    def rotated(self) -> tuple[PatchShapes, ...]:
        """Triangles contracted at vertices 1 and 2 instead, for near rules; else nothing."""
        if not self.triangular:
            return ()
        shape, degree = self.control.shape, self.patches.geometry_degree
        flat = self.control.reshape(shape[0], -1, 3)
        return tuple(PatchShapes((rotation_table(degree, v) @ flat).reshape(shape)) for v in (1, 2))

    @cached_property
    def search_points(self) -> np.ndarray:
        """Points of every piece from which the closest-point search begins, ``(n, n_q, 3)``."""
        p, outer = self.pieces, self.outer
        if p.n == self.control.shape[0]:
            return outer.offsets.reshape(p.n, -1, 3)
        nodes = outer.s[:: round(np.sqrt(outer.per_element))]
        return grid_points(self.control[p.elements], p.boxes, nodes)

    @cached_property
    def basis(self) -> csr_matrix:
        """B: density functions at the outer points, ``(n_points, n_dofs)``."""
        return density_matrix(self.patches, self.outer)

    @cached_property
    def source_basis(self) -> csr_matrix:
        """The same at the plain source points."""
        return (
            self.basis if self.source is self.outer else density_matrix(self.patches, self.source)
        )

    @cached_property
    def mass(self) -> csr_matrix:
        """Scalar mass matrix ``B^T W B``."""
        return (self.basis.T @ diags(self.outer.weights) @ self.basis).tocsr()

    @cached_property
    def constraint(self) -> np.ndarray:
        """``c_a = int N_a n``, ``(n_dofs, 3)``."""
        return self.project(self.outer.normals)

    def with_points(self, orders: QuadratureOrders) -> SampledSurface:
        """The same surface at the outer and source points of other orders.

        Parameters
        ----------
        orders : QuadratureOrders

        Returns
        -------
        SampledSurface
        """
        outer, origin = self.outer, self.outer.origin
        if orders.outer**2 != outer.per_element:
            outer = replace(point_set(self.control, orders.outer), origin=origin)
        source = outer
        if orders.source != orders.outer:
            source = replace(point_set(self.control, orders.source), origin=origin)
        return replace(self, outer=outer, source=source)

    def project(self, values: np.ndarray) -> np.ndarray:
        """Integrals ``int N_a f`` of point values.

        Parameters
        ----------
        values : (n_points, k) array

        Returns
        -------
        (n_dofs, k) array
        """
        return self.basis.T @ (self.outer.weights[:, None] * values)


def sample(
    patches: SurfacePatches, coefficients: np.ndarray, orders: QuadratureOrders
) -> SampledSurface:
    """Sample one configuration at its quadrature points.

    Parameters
    ----------
    patches : SurfacePatches
    coefficients : (n_coefficients, 3) array
    orders : QuadratureOrders
        ``outer`` and ``source`` points per direction.

    Returns
    -------
    SampledSurface

    Raises
    ------
    ValueError
        Coefficients of a wrong shape, not finite, or beyond the reach of double precision.
    """
    triangular = patches.shape == "triangle"
    if triangular:
        patches = quadrilaterals(patches)
    control, origin = centred_control(patches, coefficients)
    outer = replace(point_set(control, orders.outer), origin=origin)
    source = outer
    if orders.source != orders.outer:
        source = replace(point_set(control, orders.source), origin=origin)
    centres, radii = balls(control, np.tile([0.0, 1.0, 0.0, 1.0], (control.shape[0], 1)))
    lengths = edge_lengths(control)
    collapsed = lengths.min(axis=1) < shortest_edge(lengths.max(axis=1), control, origin)
    return SampledSurface(patches, control, outer, source, centres, radii, collapsed, triangular)


def point_set(control: np.ndarray, order: int) -> PointSet:
    """Tensor Gauss points of all elements."""
    s, t, w = gauss_square(order)
    degree = control.shape[1] - 1
    flat = control.reshape(control.shape[0], -1, 3)
    along_s, along_t = tensor_bernstein_gradient(degree, s, t)
    normal = np.cross(along_s @ flat, along_t @ flat)
    area = np.linalg.norm(normal, axis=-1)
    return PointSet(
        s,
        t,
        (tensor_bernstein(degree, s, t) @ flat).reshape(-1, 3),
        (normal / area[..., None]).reshape(-1, 3),
        (w * area).ravel(),
    )


def density_matrix(patches: SurfacePatches, points: PointSet) -> csr_matrix:
    """Density functions at tensor points, sparse ``(n, n_dofs)``."""
    local = patches.extraction @ tensor_bernstein(patches.density_degree, points.s, points.t).T
    element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
    rows = element[:, None] * points.per_element + np.arange(points.per_element)
    cols = np.broadcast_to(patches.dofs[:, None], rows.shape)
    shape = (patches.n_elements * points.per_element, patches.n_dofs)
    return coo_matrix((local.ravel(), (rows.ravel(), cols.ravel())), shape).tocsr()


def geometry_matrix(patches: SurfacePatches, points: PointSet) -> csr_matrix:
    """Coefficients to values at tensor points, sparse ``(n, n_coefficients)``."""
    if patches.shape == "triangle":
        patches = quadrilaterals(patches)
    values = tensor_bernstein(patches.geometry_degree, points.s, points.t)
    q, nb = values.shape
    e = np.arange(patches.n_elements)[:, None, None]
    rows = np.broadcast_to(e * q + np.arange(q)[:, None], (e.size, q, nb))
    cols = np.broadcast_to(e * nb + np.arange(nb), (e.size, q, nb))
    data = np.broadcast_to(values, (e.size, q, nb))
    local = coo_matrix((data.ravel(), (rows.ravel(), cols.ravel())), (e.size * q, e.size * nb))
    return (local.tocsr() @ patches.bezier).tocsr()
