"""The flow off the surface: velocity, pressure and stress at given points, inside and outside.

``u = V tau - (1 - lambda) K u + lambda u_inf`` inside, the same over lambda outside [T 5.4]; both
layers with the near rules of the assembly, so that points may lie close to the wall. The double
layer acts on the density less its value at the closest point, as K of a constant is known:
-1 inside, 0 outside (Gauss), which also tells inside from outside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .._threads_kernels import over
from ..near.closest_point import NearPairs, near_pairs
from ..near.near_field import FULL
from ..surfaces.bernstein import tensor_bernstein
from ..surfaces.configuration import real_array
from ..surfaces.quadrature import QuadratureOrders, gauss_tables
from ..surfaces.surface_points import SampledSurface
from . import _field_kernels as kernels
from .admissible import check_viscosities, velocities

WALL = 1e-6  # relative distance below which a point is on the wall
RULE = (8.0, 2.6)  # nodes on each side of the closest point: 8 + 2.6 ln(h / d)


@dataclass(frozen=True)
class FlowField:
    """A flow at points.

    Parameters
    ----------
    velocity : (n, 3) array
    pressure : (n,) array
        Up to the constant of a closed surface; viscosity of the fluid inside is 1.
    stress : (n, 3, 3) array
        ``-p I + mu (grad u + grad u^T)``.
    inside : (n,) bool array
    angle : (n,) array
        Solid angle over 4 pi: 1 inside, 0 outside, n inside n nested bodies; its distance from the
        next whole number is the error of the quadrature there.
    wall : (n,) bool array
        Points on the wall (within 1e-6 of an element): the velocity is the wall's, pressure and
        stress are NaN, as they jump there.
    """

    velocity: np.ndarray
    pressure: np.ndarray
    stress: np.ndarray
    inside: np.ndarray
    angle: np.ndarray
    wall: np.ndarray


def flow_field(
    surface: SampledSurface,
    traction: np.ndarray,
    points: np.ndarray,
    *,
    velocity: np.ndarray | None = None,
    viscosity_ratio: float = 1.0,
    background: Callable[[np.ndarray], np.ndarray] | None = None,
    orders: QuadratureOrders | None = None,
) -> FlowField:
    """Velocity, pressure and stress of a solved flow at points off the surface.

    Parameters
    ----------
    surface : SampledSurface
    traction : (n_dofs, 3) array
        Jump of the traction, coefficients of the density functions.
    points : (n, 3) array
    velocity : (n_dofs, 3) array, optional
        Velocity of the surface in the same functions; needed if the viscosities differ.
    viscosity_ratio : float
        Outer over inner viscosity. At 0 there is no fluid outside: NaN there.
    background : callable, optional
        Undisturbed velocity ``(n, 3) -> (n, 3)`` of the outer fluid. Pressure and stress are those
        of the disturbance.
    orders : QuadratureOrders, optional
        Only its ``near_ball`` counts.

    Returns
    -------
    FlowField

    Raises
    ------
    ValueError
        Arrays of the wrong shape, points not finite, or a velocity that is missing.
    """
    points = np.ascontiguousarray(real_array("points", points))
    _check(surface, traction, points, velocity, viscosity_ratio)
    double = viscosity_ratio - 1.0
    velocity = np.zeros_like(traction) if velocity is None else velocity
    density = _local(surface, np.concatenate([traction, velocity], axis=1))
    owners = np.full(points.shape[0], -1)
    ball = (orders or QuadratureOrders()).near_ball
    pairs = near_pairs(surface, points - surface.origin, owners, ball)
    nearest, values = _nearest(surface, pairs, density)
    walls = np.where(nearest[:, None] < np.inf, values[:, 3:], 0.0)
    out = _sums(surface, pairs, density, double, walls)
    angle = out[:, kernels.ANGLE]
    depth = np.rint(angle)
    out[:, :3] -= double * depth[:, None] * walls
    return _field_of(out, depth, nearest < WALL, walls, viscosity_ratio, points, background)


def _check(
    surface: SampledSurface,
    traction: np.ndarray,
    points: np.ndarray,
    velocity: np.ndarray | None,
    viscosity_ratio: float,
) -> None:
    shape = (surface.patches.n_dofs, 3)
    for name, array in (("traction", traction), ("velocity", velocity)):
        if array is not None and real_array(name, array).shape != shape:
            raise ValueError(f"{name}: expected coefficients {shape}, got {np.shape(array)}")
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points: expected finite values (n, 3), got shape {points.shape}")
    check_viscosities(1.0, viscosity_ratio, background=False)
    if viscosity_ratio != 1.0 and velocity is None:
        raise ValueError(
            f"viscosity_ratio = {viscosity_ratio:g} needs the double layer: give the velocity of "
            "the surface too"
        )


def _local(surface: SampledSurface, coefficients: np.ndarray) -> np.ndarray:
    """Bernstein coefficients by element, ``(n_elements, q + 1, q + 1, k)``."""
    p = surface.patches
    rows = p.extraction[:, :, None] * coefficients[p.dofs][:, None, :]
    local = np.add.reduceat(rows, p.indptr[:-1], axis=0)
    m = p.density_degree + 1
    return np.ascontiguousarray(local.reshape(p.n_elements, m, m, -1))


def _nearest(
    surface: SampledSurface, pairs: NearPairs, density: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Relative distance of the closest near piece (inf: none), traction and velocity there."""
    n = pairs.points.shape[0]
    size = pairs.boxes[:, [1, 3]] - pairs.boxes[:, [0, 2]]
    distance = (pairs.closest.distances / size).min(axis=1)
    point = np.repeat(np.arange(n), np.diff(pairs.indptr))
    first = np.lexsort((distance, point))
    first = first[np.diff(point[first], prepend=-1) > 0]
    at_pair = np.empty((first.size, 6))
    pair = pairs.elements[first], pairs.closest[first].rows
    over(first.size, kernels.densities, *pair, density, at_pair)
    nearest, values = np.full(n, np.inf), np.zeros((n, 6))
    nearest[point[first]], values[point[first]] = distance[first], at_pair
    return nearest, values


def _sums(
    surface: SampledSurface,
    pairs: NearPairs,
    density: np.ndarray,
    double: float,
    walls: np.ndarray,
) -> np.ndarray:
    """All integrals at all points, ``(n, 11)``."""
    source, n = surface.source, surface.patches.n_elements
    table = tensor_bernstein(density.shape[1] - 1, source.s, source.t)
    values = np.einsum("qk,ekc->eqc", table, density.reshape(n, -1, 6), optimize=True)
    nodes, weights = gauss_tables()
    out = np.empty((pairs.points.shape[0], kernels.SIZE))
    over(
        -(-out.shape[0] // kernels.BLOCK), kernels.fields, pairs.points, pairs.indptr,
        pairs.elements, pairs.closest.rows, pairs.boxes, surface.control, density,
        source.offsets.reshape(n, -1, 3),
        (source.weights[:, None] * source.normals).reshape(n, -1, 3), np.ascontiguousarray(values),
        RULE, double, nodes, weights, walls, out,
    )  # fmt: skip
    return out


def _field_of(
    out: np.ndarray,
    depth: np.ndarray,
    wall: np.ndarray,
    walls: np.ndarray,
    ratio: float,
    points: np.ndarray,
    background: Callable[[np.ndarray], np.ndarray] | None,
) -> FlowField:
    velocity, inside = out[:, :3], depth > 0.5
    if background is not None:
        velocity = velocity + ratio * velocities("background", background(points), points)
    pressure, stress = out[:, kernels.PRESSURE], out[:, kernels.STRESS : kernels.ANGLE]
    if ratio != 1.0:
        viscosity = ratio + (1.0 - ratio) * depth
        # no fluid outside: no flow to speak of
        velocity = velocity / np.where(viscosity > 0.0, viscosity, np.nan)[:, None]
        if ratio == 0.0:
            pressure = np.where(inside, pressure, np.nan)
            stress = np.where(inside[:, None], stress, np.nan)
    velocity = np.where(wall[:, None], walls, velocity)
    pressure = np.where(wall, np.nan, pressure)
    stress = np.where(wall[:, None], np.nan, stress)
    matrix = stress[:, FULL].reshape(-1, 3, 3)
    return FlowField(velocity, pressure, matrix, inside, out[:, kernels.ANGLE], wall)
