"""Bodies that cross each other, and bodies inside bodies.

Two surfaces that cross have points at distance zero: where bounding boxes overlap, the closest
points of neighbouring elements are sought as for `facing_gap`. Bodies that do not cross are apart
or nested, which the winding number of one's points about the other tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .._threads_kernels import over
from ..surfaces.subdivision import grid_points
from ..surfaces.surface_points import SampledSurface
from . import _facing_kernels as kernels

NEIGHBOURS = 8  # samples of the other body from which the closest points are sought
TOUCH = 1e-9  # of an element's size: a smaller distance is a contact
TRIANGULATED = 8  # pieces of an element along s and along t, for winding numbers
PROBES = 6  # the samples of each end of a body are this part of all


@dataclass(frozen=True)
class Arrangement:
    """How several closed bodies lie to each other.

    Parameters
    ----------
    inside : (n_bodies, n_bodies) bool array
        Whether the first body lies inside the second.
    crossing : tuple or None
        Two bodies that cross or touch, and a point ``(3,)`` where they do.
    tested : int
        Pairs of bodies whose boxes overlap; all others were not looked at.
    """

    inside: np.ndarray
    crossing: tuple[int, int, np.ndarray] | None
    tested: int

    @property
    def depth(self) -> np.ndarray:
        """Number of bodies around each body, ``(n_bodies,)``."""
        return self.inside.sum(axis=1)


def arrangement(surface: SampledSurface, body: np.ndarray) -> Arrangement:
    """Look for bodies that cross, and for bodies inside others.

    Parameters
    ----------
    surface : SampledSurface
    body : (n_elements,) int array
        Closed body of each element.

    Returns
    -------
    Arrangement
    """
    n = int(body.max()) + 1
    inside = np.zeros((n, n), bool)
    pairs = overlapping_boxes(surface, body)
    for a, b in pairs:
        first, second = (np.flatnonzero(body == k) for k in (a, b))
        at = _common_point(surface, first, second)
        if at is None:
            for (i, mine), (j, other) in (((a, first), (b, second)), ((b, second), (a, first))):
                x = _deepest(surface, mine, other)
                around = winding_numbers(surface, other, x) > 0.5
                inside[i, j] = around.all()
                if around.any() and not around.all():
                    at = x[around.argmax()]
        if at is not None:
            return Arrangement(inside, (int(a), int(b), at + surface.origin), len(pairs))
    return Arrangement(inside, None, len(pairs))


def _common_point(
    surface: SampledSurface, first: np.ndarray, second: np.ndarray
) -> np.ndarray | None:
    """A point of both of two sets of elements, relative to the origin; None if there is none."""
    per, points = surface.outer.per_element, surface.outer.offsets
    samples = [(k[:, None] * per + np.arange(per)).ravel() for k in (first, second)]
    away, _ = cKDTree(surface.centres[second]).query(surface.centres[first])
    if np.all(away > surface.radii[first] + surface.radii[second].max()):
        return None
    found = []
    for mine, other in (samples, samples[::-1]):
        count = min(NEIGHBOURS, other.size)
        distance, index = cKDTree(points[other]).query(points[mine], k=count)
        pairs = np.stack([np.repeat(mine, count), other[index.reshape(-1)]])
        found.append(np.vstack([pairs if mine is samples[0] else pairs[::-1], distance.ravel()]))
    i, j, distance = np.concatenate(found, axis=1)
    i, j = i.astype(np.int64), j.astype(np.int64)
    order = np.lexsort((distance, j // per, i // per))
    key = (i // per * surface.control.shape[0] + j // per)[order]
    order = order[np.flatnonzero(np.diff(key, prepend=-1))]
    e, f = i[order] // per, j[order] // per
    near = np.linalg.norm(surface.centres[e] - surface.centres[f], axis=1)
    order = order[near <= surface.radii[e] + surface.radii[f]]
    if order.size == 0:
        return None
    e, f = i[order] // per, j[order] // per
    st = np.stack([surface.outer.s, surface.outer.t], axis=1)
    local = np.concatenate([st[i[order] % per], st[j[order] % per]], axis=1)
    gap = np.empty(e.size)
    patches = surface.shapes.powers, surface.control
    over(e.size, kernels.approach_all, *patches, e, f, local, gap)
    k = int(np.argmin(gap))
    if gap[k] > TOUCH * max(surface.radii[e[k]], surface.radii[f[k]]):
        return None
    jets = np.empty((1, 6, 3))
    st = np.ascontiguousarray(local[k : k + 1, :2])
    kernels.jets((0, 1), *patches, e[k : k + 1], st, jets)
    return jets[0, 0]


def _deepest(surface: SampledSurface, mine: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Samples of some elements in all directions and those farthest from others, ``(n, 3)``."""
    per, points = surface.outer.per_element, surface.outer.offsets
    x, y = (points.reshape(-1, per, 3)[k].reshape(-1, 3) for k in (mine, other))
    distance, _ = cKDTree(y).query(x)
    # of every extreme region the sample that is farthest from the other body
    chosen = [int(distance.argmax())]
    for axis in range(3):
        order = np.argsort(x[:, axis], kind="stable")
        share = max(1, order.size // PROBES)
        for part in (order[:share], order[-share:]):
            chosen.append(int(part[distance[part].argmax()]))
    return x[np.unique(chosen)]


def overlapping_boxes(surface: SampledSurface, body: np.ndarray) -> np.ndarray:
    """Pairs of bodies ``(n, 2)`` whose axis-parallel boxes of control points overlap."""
    net = surface.control.reshape(surface.control.shape[0], -1, 3)
    n = int(body.max()) + 1
    low, high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    np.minimum.at(low, body, net.min(axis=1))
    np.maximum.at(high, body, net.max(axis=1))
    meet = np.all(low[:, None] <= high[None], axis=2)
    return np.argwhere(np.triu(meet & meet.T, 1))


def winding_numbers(surface: SampledSurface, elements: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Winding number of the triangulated elements of one body about points ``x (n, 3)``.

    Exact of the triangles, by their solid angles; 1 inside, 0 outside.
    """
    k = TRIANGULATED + 1
    ticks = np.linspace(0.0, 1.0, k)
    boxes = np.tile([0.0, 1.0, 0.0, 1.0], (elements.size, 1))
    grid = grid_points(surface.control[elements], boxes, ticks).reshape(-1, k, k, 3)
    a, b, c, d = grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]
    corners = [np.concatenate(p).reshape(-1, 3) for p in ((a, a), (b, c), (c, d))]
    return np.array([_solid_angle(*(p - point for p in corners)) for point in x]) / (4.0 * np.pi)


def _solid_angle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Sum of the solid angles of triangles about the origin (van Oosterom and Strackee)."""
    lengths = [np.linalg.norm(v, axis=1) for v in (a, b, c)]
    p, q, r = lengths
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    rest = p * q * r + _dot(a, b) * r + _dot(b, c) * p + _dot(c, a) * q
    return 2.0 * float(np.arctan2(volume, rest).sum())


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)
