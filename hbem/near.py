"""Near correction of the single layer: accurate minus plain integrals, ``C_near``.

Per pair the moments of the six kernel components against Bernstein polynomials: polar rule on
the point's own element (doubled where an edge is collapsed), tensor sinh rule about the closest
point elsewhere. Elements that turn by more than about 45 degrees should be split first: they
would enter `near_pairs` as several sources with one table each.
"""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.sparse import csr_matrix

from . import _near_kernels as kernels
from .closest_point import NearPairs
from .patches import tensor_bernstein
from .quadrature import QuadratureOrders, gauss_tables
from .sampling import SampledSurface

COINCIDENT = 1e-12  # distances below this fraction of the body are the same point


def coincidence(surface: SampledSurface) -> float:
    """Squared distance below which the plain rule skips a point pair."""
    extent = np.linalg.norm(np.ptp(surface.centres, axis=0)) + 2.0 * surface.radii.max()
    return float((COINCIDENT * extent) ** 2)


def accurate_moments(
    surface: SampledSurface, pairs: NearPairs, orders: QuadratureOrders
) -> np.ndarray:
    """Accurate moments of near pairs, ``(n_pairs, (q + 1) ** 2, 6)``."""
    q = surface.patches.density_degree
    nodes, weights = gauss_tables()
    cubic = cubic_coefficients(surface.control)
    moments = np.empty((pairs.n_pairs, (q + 1) ** 2, 6))
    kernels.near_moments(
        pairs.points,
        pairs.indptr,
        pairs.elements,
        pairs.found,
        surface.control,
        cubic,
        surface.collapsed,
        q,
        (orders.near_offset, orders.near_slope),
        (orders.radial, orders.angular),
        nodes,
        weights,
        coincidence(surface),
        moments,
    )
    return moments


def cubic_coefficients(control: np.ndarray) -> np.ndarray:
    """Power coefficients ``(n_elements, 3, 4, 4)`` of patches up to degree 3, else empty."""
    degree = control.shape[1] - 1
    if degree > 3:
        return np.empty((0, 3, 4, 4))
    power = np.zeros((4, degree + 1))
    for j in range(degree + 1):
        for k in range(j, degree + 1):
            power[k, j] = comb(degree, k) * comb(k, j) * (-1) ** (k - j)
    return np.ascontiguousarray(np.einsum("ki,eijc,lj->eckl", power, control, power))


def near_correction(
    surface: SampledSurface, pairs: NearPairs, orders: QuadratureOrders
) -> np.ndarray:
    """Accurate minus plain moments of near pairs, ``(n_pairs, (q + 1) ** 2, 6)``."""
    moments = accurate_moments(surface, pairs, orders)
    source, n = surface.source, surface.centres.shape[0]
    kernels.subtract_plain(
        pairs.points,
        pairs.indptr,
        pairs.elements,
        source.points.reshape(n, -1, 3),
        source.weights.reshape(n, -1),
        tensor_bernstein(surface.patches.density_degree, source.s, source.t),
        coincidence(surface),
        moments,
    )
    return moments


def sparse_correction(
    surface: SampledSurface, pairs: NearPairs, moments: np.ndarray
) -> list[csr_matrix]:
    """C_near: six sparse matrices ``(n_points, n_dofs)``, one per component."""
    patches = surface.patches
    nb = moments.shape[1]
    columns = (pairs.elements[:, None] * nb + np.arange(nb)).ravel()
    shape = (pairs.indptr.size - 1, patches.n_elements * nb)
    element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
    rows = (element[:, None] * nb + np.arange(nb)).ravel()
    entries = (patches.extraction.ravel(), (rows, np.repeat(patches.dofs, nb)))
    functions = csr_matrix(entries, shape=(shape[1], patches.n_dofs))
    parts = []
    for c in range(6):
        data = np.ascontiguousarray(moments[:, :, c]).ravel()
        parts.append(csr_matrix((data, columns, pairs.indptr * nb), shape=shape) @ functions)
    return parts
