"""Accurate integrals of near pairs: moments of a layer's kernel against Bernstein polynomials.

Polar rule on the point's own element (doubled where an edge is collapsed); elsewhere a tensor
rule ``s = s0 + b sinh(v)`` about the closest point, one stretch for the single layer, split at
``s0`` for the stronger double layer. ``C_near`` is the accurate minus the plain rule.
"""

from __future__ import annotations

import enum

import numpy as np

from . import _tensor_kernels as kernels
from .closest_point import NearPairs
from .quadrature import QuadratureOrders, gauss_tables
from .sampling import SampledSurface

COINCIDENT = 1e-12  # distances below this fraction of the body are the same point


class Layer(enum.IntEnum):
    """Which kernel: ``SINGLE`` [T 3.10a] or ``DOUBLE`` [T 3.10b]."""

    SINGLE = 0
    DOUBLE = 1


def coincidence(surface: SampledSurface) -> float:
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
    q, g = surface.patches.density_degree, surface.patches.geometry_degree
    nodes, weights = gauss_tables()
    n = pairs.n_pairs
    moments = np.empty((n, (q + 1) ** 2, 6))
    counts, keys = np.empty((n, 2), np.int64), np.empty(n, np.uint16)
    plain = pairs.first.astype(np.int64) if minus_plain else np.zeros(n, np.int64)
    split, rule = layer is Layer.DOUBLE, orders.rule(layer)
    boxes = surface.pieces.boxes
    largest = nodes.shape[0] - 1
    point_of = np.repeat(np.arange(pairs.points.shape[0]), np.diff(pairs.indptr))
    kernels.choose(
        pairs.found, boxes, pairs.pieces, pairs.elements, surface.collapsed, plain, rule, split,
        largest, counts, keys,
    )  # fmt: skip
    ordered = np.argsort(keys, kind="stable")
    kernels.near_moments(
        pairs.points, point_of, pairs.elements, pairs.pieces, pairs.found, boxes, counts, plain,
        ordered, _groups(keys[ordered]), g, surface.shapes, surface.control, surface.collapsed,
        q, int(layer), split, (orders.radial, orders.angular), orders.source, nodes, weights,
        coincidence(surface), moments,
    )  # fmt: skip
    return moments


def _groups(keys: np.ndarray) -> np.ndarray:
    """Beginnings of groups of equal keys, at most `LANES` each, and the end."""
    starts = np.flatnonzero(np.diff(keys.astype(np.int64), prepend=-1))
    sizes = np.diff(np.append(starts, keys.size))
    counts = -(-sizes // kernels.LANES)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(np.repeat(starts, counts) + kernels.LANES * within, keys.size)
