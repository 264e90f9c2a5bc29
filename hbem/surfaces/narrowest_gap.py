"""The narrowest gap of a surface: where walls face each other, how far apart, over what extent.

For every distance G the region of points that face a wall closer than G has an area A(G); it
counts both walls, so its lateral extent is ``l = sqrt(A / 2 pi)``. The gap that matters to
lubrication is the one of smallest thinness ``G / 2 l(G)``: a thin rim counts less than a thin disc.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .surface_points import SampledSurface

OPPOSED = -0.7  # cosine between normals of walls that face each other
NEIGHBOURS = 8
FAT = 0.7  # extents within which walls are sought: no table knows gaps of that thinness, 0.35


@dataclass(frozen=True)
class NarrowestGap:
    """Distance of two facing walls and the extent of their gap; thinness is ``d / 2 l``."""

    distance: float
    extent: float

    @property
    def thinness(self) -> float:
        return self.distance / (2.0 * self.extent)


def narrowest(surface: SampledSurface) -> NarrowestGap:
    """The narrowest gap of a sampled surface, inside or outside."""
    outer = surface.outer
    reach = FAT * largest_extent(surface)
    distance = facing_distance(outer.offsets, outer.normals, reach)
    order = np.argsort(distance)
    area = np.cumsum(outer.weights[order])
    extent = np.sqrt(area / (2.0 * np.pi))
    # a single facing point is no gap: start at a thousandth of the area
    thinness = np.where(area > 1e-3 * area[-1], distance[order] / (2.0 * extent), np.inf)
    at = int(np.argmin(thinness))
    if not np.isfinite(thinness[at]):
        size = float(np.linalg.norm(np.ptp(outer.offsets, axis=0)))
        return NarrowestGap(size, float(extent[-1]))
    return NarrowestGap(float(distance[order[at]]), float(extent[at]))


def largest_extent(surface: SampledSurface) -> float:
    """Extent of a gap to which the whole surface belongs."""
    return float(np.sqrt(surface.outer.weights.sum() / (2.0 * np.pi)))


def facing_distance(points: np.ndarray, normals: np.ndarray, reach: float = np.inf) -> np.ndarray:
    """Distance from each point to the nearest wall that faces it, ``(n,)``; inf if none does.

    Measured along the mean normal, so that samples need not lie exactly opposite each other.
    """
    found = np.full(points.shape[0], np.inf)
    spacing = _spacing(points)
    for mine, index in opposed_neighbours(points, normals, reach):
        offset = points[index] - points[mine, None]
        mean = normals[mine, None] - normals[index]
        length = np.linalg.norm(mean, axis=-1)
        along = np.abs(np.einsum("ijc,ijc->ij", offset, mean)) / np.maximum(length, 1e-300)
        square = np.einsum("ijc,ijc->ij", offset, offset)
        lateral = np.sqrt(np.maximum(square - along**2, 0.0))
        opposed = np.einsum("ic,ijc->ij", normals[mine], normals[index]) < OPPOSED
        valid = opposed & (lateral <= np.maximum(along, spacing[mine, None]))
        found[mine] = np.where(valid, along, np.inf).min(axis=1)
    return found


def opposed_neighbours(
    points: np.ndarray, normals: np.ndarray, reach: float = np.inf
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The nearest points with roughly opposed normals: some points and ``(n, k)`` indices each.

    Every point that has any within ``reach`` occurs once. Without that bound a search on a sphere
    looks at all opposite points, which are equally far.
    """
    directions = _directions()
    nearest = np.argmax(normals @ directions.T, axis=1)
    for d in range(directions.shape[0]):
        mine = np.flatnonzero(nearest == d)
        other = np.flatnonzero(normals @ directions[d] < OPPOSED)
        if mine.size and other.size:
            k = min(NEIGHBOURS, other.size)
            tree = cKDTree(points[other])
            _, index = tree.query(points[mine], k=k, distance_upper_bound=reach)
            index = index.reshape(mine.size, k)
            some = index[:, 0] < other.size
            index = np.where(index < other.size, index, index[:, :1])[some]
            yield mine[some], other[index]


def _spacing(points: np.ndarray) -> np.ndarray:
    """Distance over which samples can miss each other: that of the eighth neighbour."""
    k = min(9, points.shape[0])
    distance, _ = cKDTree(points).query(points, k=k)
    return distance[:, -1]


def _directions() -> np.ndarray:
    """The 26 directions to faces, edges and corners of a cube, ``(26, 3)``."""
    grid = np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1], indexing="ij"), axis=-1)
    grid = grid.reshape(-1, 3).astype(float)
    grid = grid[np.any(grid != 0.0, axis=1)]
    return grid / np.linalg.norm(grid, axis=1, keepdims=True)
