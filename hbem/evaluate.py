"""The flow off the surface: velocity, pressure and stress at given points, up to the wall.

With ``tau`` the traction jump, ``lambda`` the viscosity ratio and c = 1 inside, lambda outside,

    c u(x) = V tau - (1 - lambda) K u + lambda u_inf            from [T 5.4]

and for equal viscosities ``p = int r . tau / (4 pi r^3)``,
``sigma_ij = -3 int r_i r_j (r . tau) / (4 pi r^5)``, in units of the viscosity. Points near the
wall use the near rules of the operators; a point is inside where ``K[1] = -1``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from .closest_point import NearPairs, near_pairs
from .double_layer import plain_sums
from .near import Layer, coincidence, near_moments
from .near_field import FULL
from .patches import SurfacePatches, tensor_bernstein, tensor_bernstein_gradient
from .point_sums import single_layer_sums
from .quadrature import LARGEST, QuadratureOrders, gauss
from .sampling import SampledSurface


@dataclass(frozen=True)
class FlowField:
    """The flow at points off the surface.

    Attributes
    ----------
    velocity : (n, 3) array
    inside : (n,) bool array
    pressure : (n,) array or None
        Up to the constant that ``<tau, n> = 0`` fixes; the same inside and outside.
    stress : (n, 3, 3) array or None
        Cauchy stress, pressure included.
    """

    velocity: np.ndarray
    inside: np.ndarray
    pressure: np.ndarray | None = None
    stress: np.ndarray | None = None


def flow_field(
    surface: SampledSurface,
    points: np.ndarray,
    traction: np.ndarray,
    orders: QuadratureOrders,
    *,
    velocity: np.ndarray | None = None,
    viscosity_ratio: float = 1.0,
    background: np.ndarray | float = 0.0,
    stress: bool = False,
) -> FlowField:
    """Evaluate the flow of a solved boundary problem.

    Parameters
    ----------
    surface : SampledSurface
    points : (n, 3) array
        Off the surface.
    traction : (n_dofs, 3) array
        Coefficients of the traction jump.
    orders : QuadratureOrders
    velocity : (n_dofs, 3) array, optional
        Boundary velocity in the density space; needed for ``viscosity_ratio != 1``.
    viscosity_ratio : float
    background : (n, 3) array or float
        Velocity at infinity, at the points.
    stress : bool
        Also pressure and stress; equal viscosities only.

    Raises
    ------
    ValueError
        Points of a wrong shape, a missing velocity, or stress at unequal viscosities.
    """
    x = np.ascontiguousarray(points, dtype=float)
    if x.ndim != 2 or x.shape[1] != 3 or not np.all(np.isfinite(x)):
        raise ValueError(f"points must be a finite array (n, 3), got shape {x.shape}")
    equal = viscosity_ratio == 1.0
    if stress and not equal:
        raise ValueError("pressure and stress are evaluated for viscosity_ratio = 1 only")
    if not equal and velocity is None:
        raise ValueError("viscosity_ratio != 1 needs the boundary velocity as well")
    pairs = near_pairs(surface, x, np.full(x.shape[0], -1), orders.near_ball)
    total = _single(surface, pairs, traction, orders) + viscosity_ratio * background
    double, inside = _double(surface, pairs, velocity, orders)
    if not equal:
        total = total - (1.0 - viscosity_ratio) * double
    u = total / np.where(inside, 1.0, viscosity_ratio)[:, None]
    if not stress:
        return FlowField(u, inside)
    pressure, cauchy = _stress(surface, pairs, traction, orders)
    return FlowField(u, inside, pressure, cauchy)


def bernstein_coefficients(patches: SurfacePatches, density: np.ndarray) -> np.ndarray:
    """A density on every element in Bernstein form, ``(n_elements, (q + 1)**2, k)``."""
    nb = patches.extraction.shape[1]
    element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
    rows = (element[:, None] * nb + np.arange(nb)).ravel()
    entries = (patches.extraction.ravel(), (rows, np.repeat(patches.dofs, nb)))
    table = csr_matrix(entries, shape=(patches.n_elements * nb, patches.n_dofs))
    return (table @ density).reshape(patches.n_elements, nb, -1)


def _sum_by_point(pairs: NearPairs, values: np.ndarray) -> np.ndarray:
    out = np.zeros((pairs.points.shape[0], *values.shape[1:]))
    np.add.at(out, np.repeat(np.arange(out.shape[0]), np.diff(pairs.indptr)), values)
    return out


def _contract(moments: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Moments ``(n_pairs, nb, 6)`` times densities ``(n_pairs, nb, 3)``."""
    matrices = moments[:, :, FULL].reshape(*moments.shape[:2], 3, 3)
    return np.einsum("pbik,pbk->pi", matrices, coefficients, optimize=True)


def _single(surface, pairs, traction, orders):
    source = surface.source
    strengths = source.weights[:, None] * (surface.source_basis @ traction)
    far = single_layer_sums(pairs.points, source.points, strengths, coincidence(surface))
    moments = near_moments(surface, pairs, orders, minus_plain=True)
    local = bernstein_coefficients(surface.patches, traction)[pairs.elements]
    return far + _sum_by_point(pairs, _contract(moments, local))


def _double(surface, pairs, velocity, orders):
    """Double-layer velocity (or None) and which points are inside."""
    values = None if velocity is None else (surface.source_basis @ velocity)[:, :, None]
    sums, total = plain_sums(surface, pairs.points, values)
    moments = near_moments(surface, pairs, orders, Layer.DOUBLE, minus_plain=True)
    total = total + _sum_by_point(pairs, moments.sum(axis=1))
    inside = -(total[:, 0] + total[:, 3] + total[:, 5]) > 1.5
    if velocity is None:
        return None, inside
    local = bernstein_coefficients(surface.patches, velocity)[pairs.elements]
    return sums[:, :, 0] + _sum_by_point(pairs, _contract(moments, local)), inside


def _stress_sums(x: np.ndarray, y: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Pressure and six stresses at ``x (n, 3)`` of forces f at y, ``(n, 7)``."""
    out = np.zeros((x.shape[0], 7))
    for start in range(0, x.shape[0], 64):
        r = x[start : start + 64, None] - y
        square = np.sum(r * r, axis=2)
        along = np.einsum("nqc,qc->nq", r, f) / (4.0 * np.pi * square * np.sqrt(square))
        out[start : start + 64, 0] = along.sum(axis=1)
        weight = -3.0 * along / square
        for c, (i, k) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
            out[start : start + 64, 1 + c] = np.sum(weight * r[:, :, i] * r[:, :, k], axis=1)
    return out


def _stress(surface, pairs, traction, orders):
    """Pressure and stress: plain sums, and the split near rule instead of them at near pairs."""
    source, patches = surface.source, surface.patches
    f = source.weights[:, None] * (surface.source_basis @ traction)
    sums = _stress_sums(pairs.points, source.points, f)
    local, nq = bernstein_coefficients(patches, traction), source.per_element
    point_of = np.repeat(np.arange(pairs.points.shape[0]), np.diff(pairs.indptr))
    for k in range(pairs.n_pairs):
        p, e = point_of[k], pairs.elements[k]
        x = pairs.points[p : p + 1]
        y, w, s, t = _near_points(surface, pairs, k, orders)
        values = tensor_bernstein(patches.density_degree, s, t) @ local[e]
        sums[p] += _stress_sums(x, y, w[:, None] * values)[0]
        if pairs.first[k]:
            plain = slice(e * nq, (e + 1) * nq)
            sums[p] -= _stress_sums(x, source.points[plain], f[plain])[0]
    return sums[:, 0], sums[:, 1 + FULL].reshape(-1, 3, 3)


def _near_points(surface, pairs, k, orders):
    """Points, weights and coordinates of the split rule of one pair, one order up."""
    box = surface.pieces.boxes[pairs.pieces[k]]
    lines = [
        _split_line(pairs.found[k, i], pairs.found[k, 2 + i], box[2 * i], box[2 * i + 1], orders)
        for i in range(2)
    ]
    s, t = (g.ravel() for g in np.meshgrid(lines[0][0], lines[1][0], indexing="ij"))
    control = surface.control[pairs.elements[k]]
    degree, flat = control.shape[0] - 1, control.reshape(-1, 3)
    ys, yt = (table @ flat for table in tensor_bernstein_gradient(degree, s, t))
    w = np.outer(lines[0][1], lines[1][1]).ravel() * np.linalg.norm(np.cross(ys, yt), axis=1)
    return tensor_bernstein(degree, s, t) @ flat, w, s, t


def _split_line(centre, b, low, high, orders):
    """One direction of the split sinh rule in numpy, as the compiled one."""
    offset, slope = orders.rule(Layer.DOUBLE)
    b = max(b, 1e-6 * (high - low))
    n = int(np.clip(np.ceil(offset + 2 - slope * np.log(b / (high - low))), 4, LARGEST))
    nodes, weights = [], []
    for a, c in ((low, centre), (centre, high)):
        if c - a <= 1e-9 * (high - low):
            continue
        x, w = gauss(n)
        start = np.arcsinh((a - centre) / b)
        length = np.arcsinh((c - centre) / b) - start
        v = start + length * x
        nodes.append(centre + b * np.sinh(v))
        weights.append(b * np.cosh(v) * length * w)
    return np.concatenate(nodes), np.concatenate(weights)
