"""Accurate integrals of near pairs: moments of a layer's kernel against Bernstein polynomials.

Polar rule on the point's own element (doubled where an edge is collapsed); elsewhere a tensor
rule ``s = s0 + b sinh(v)`` about the closest point, one stretch for the single layer, split at
``s0`` for the stronger double layer. Triangles are contracted at the vertex farthest from the
closest point for that. ``C_near`` is the accurate minus the plain rule.
"""

from __future__ import annotations

import enum

import numpy as np

from .._threads_kernels import over
from ..surfaces.quadrature import QuadratureOrders, gauss_tables
from ..surfaces.surface_points import PatchShapes, SampledSurface
from ..surfaces.triangles import barycentric, rotation_table
from . import _sinh_rule_kernels as kernels
from .closest_point import ClosestPoints, NearPairs
from .rotated_triangles import rotate_vertices

COINCIDENT = 1e-12  # distances below this fraction of the body are the same point


class Layer(enum.IntEnum):
    """Which kernel: ``SINGLE`` [T 3.10a] or ``DOUBLE`` [T 3.10b]."""

    SINGLE = 0
    DOUBLE = 1


def coincident_distance_squared(surface: SampledSurface) -> float:
    """Squared distance below which the plain rule skips a point pair."""
    extent = np.linalg.norm(np.ptp(surface.centres, axis=0)) + 2.0 * surface.radii.max()
    return float((COINCIDENT * extent) ** 2)


def near_moments(
    surface: SampledSurface,
    pairs: NearPairs,
    orders: QuadratureOrders,
    layer: Layer = Layer.SINGLE,
    *,
    minus_plain: bool = False,
) -> np.ndarray:
    """Moments of near pairs, ``(n_pairs, (q + 1) ** 2, 6)``.

    Parameters
    ----------
    surface : SampledSurface
    pairs : NearPairs
    orders : QuadratureOrders
    layer : Layer
    minus_plain : bool
        Subtract the plain rule of each pair, as the far field will add it back.
    """
    n, q = pairs.n_pairs, surface.patches.density_degree
    plain = pairs.first.astype(np.int64) if minus_plain else np.zeros(n, np.int64)
    point_of = np.repeat(np.arange(pairs.points.shape[0]), np.diff(pairs.indptr))
    vertex = _vertices(surface, pairs)
    moments = _moments(
        surface, surface.shapes, pairs, slice(None), point_of, pairs.closest, plain, vertex > 0,
        orders, layer,
    )  # fmt: skip
    for v, rotated in enumerate(surface.rotated, start=1):
        k = np.flatnonzero(vertex == v)
        if k.size == 0:
            continue
        closest = rotate_vertices(pairs.closest[k], pairs.elements[k], v, surface, rotated)
        none = np.zeros(k.size, np.int64)
        part = _moments(
            surface, rotated, pairs, k, point_of[k], closest, none, none > 0, orders, layer
        )
        moments[k] += rotation_table(q, v).T @ part
    return moments


def _vertices(surface: SampledSurface, pairs: NearPairs) -> np.ndarray:
    """Vertex at which the triangle of each pair is contracted; 0 for all others."""
    if not surface.rotated:
        return np.zeros(pairs.n_pairs, np.int64)
    # a piece has another shape in the other contractions; a whole element is the same square
    whole = np.all(pairs.boxes == [0.0, 1.0, 0.0, 1.0], axis=1)
    apart = pairs.closest.distances[:, 0] >= 0.0
    return np.where(whole & apart, barycentric(pairs.closest.s, pairs.closest.t).argmin(axis=1), 0)


def _moments(
    surface: SampledSurface,
    shapes: PatchShapes,
    pairs: NearPairs,
    k: np.ndarray | slice,
    point_of: np.ndarray,
    closest: ClosestPoints,
    plain: np.ndarray,
    only_plain: np.ndarray,
    orders: QuadratureOrders,
    layer: Layer,
) -> np.ndarray:
    """Moments of some pairs by one contraction; the rule is left out where `only_plain`."""
    q = surface.patches.density_degree
    nodes, weights = gauss_tables()
    elements, boxes = pairs.elements[k], pairs.boxes[k]
    n = elements.size
    moments = np.empty((n, (q + 1) ** 2, 6))
    counts, keys = np.empty((n, 2), np.int64), np.empty(n, np.uint16)
    split, rule, largest = layer is Layer.DOUBLE, orders.rule(layer), nodes.shape[0] - 1
    over(
        n, kernels.choose, closest.rows, boxes, elements, surface.collapsed, plain,
        rule, split, largest, counts, keys,
    )  # fmt: skip
    counts[only_plain] = 0
    keys[only_plain] = plain[only_plain]
    ordered = np.argsort(keys, kind="stable")
    groups = _groups(keys[ordered])
    form = shapes.powers, (0.0,) * (q + 1), (0.0,) * int(layer)
    over(
        groups.size - 1, kernels.near_moments, form,
        pairs.points, point_of, elements, closest.rows, boxes, counts, plain, ordered, groups,
        shapes.power_coefficients, shapes.control, surface.collapsed, split,
        (orders.radial, orders.angular), orders.source, nodes, weights,
        coincident_distance_squared(surface), moments,
    )  # fmt: skip
    return moments


def _groups(keys: np.ndarray) -> np.ndarray:
    """Beginnings of groups of equal keys, at most `LANES` each, and the end."""
    starts = np.flatnonzero(np.diff(keys.astype(np.int64), prepend=-1))
    sizes = np.diff(np.append(starts, keys.size))
    counts = -(-sizes // kernels.LANES)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(np.repeat(starts, counts) + kernels.LANES * within, keys.size)
