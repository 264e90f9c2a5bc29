"""Triangulations without any structure for shells: smoothed Delaunay meshes, spheres."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import Delaunay

from shells.surfaces.local_elements import lattice
from shells.surfaces.triangles.triangle_surface import TriangleSurface

from .raw_bodies import raw_sphere


def _smoothed(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Each point moved to the mean of its neighbours."""
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    both = np.concatenate([edges, edges[:, ::-1]])
    total = np.zeros_like(points)
    np.add.at(total, both[:, 0], points[both[:, 1]])
    return total / np.bincount(both[:, 0], minlength=len(points))[:, None]


def rectangle(
    n: int,
    m: int | None = None,
    size: tuple[float, float] = (1.0, 1.0),
    seed: int = 0,
    rounds: int = 3,
) -> tuple[np.ndarray, np.ndarray]:
    """Delaunay mesh of ``n x m`` random points, n and m to each side: points (k, 2), triangles.

    Three rounds of smoothing leave 30 to 35 % of the vertices with six neighbours; without any
    there are slivers.
    """
    m = n if m is None else m
    x, y = np.arange(n) / n, np.arange(m) / m
    rim = np.concatenate(
        [
            np.stack([x, 0.0 * x], axis=1),
            np.stack([1.0 + 0.0 * y, y], axis=1),
            np.stack([1.0 - x, 1.0 + 0.0 * x], axis=1),
            np.stack([0.0 * y, 1.0 - y], axis=1),
        ]
    )
    inner = np.random.default_rng(seed).uniform(0.5 / max(n, m), 1.0 - 0.5 / max(n, m), (n * m, 2))
    points, scale = np.concatenate([rim, inner]), np.array(size)
    for _ in range(rounds):
        moved = _smoothed(points, Delaunay(points * scale).simplices)
        points[len(rim) :] = moved[len(rim) :]
    return points * scale, _upwards(points, Delaunay(points * scale).simplices)


def _upwards(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Counterclockwise triangles, flat ones along the rim dropped."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    turned = np.where((area > 0.0)[:, None], triangles, triangles[:, [0, 2, 1]])
    return turned[np.abs(area) > 1e-10]


def sphere(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Raw unit sphere of n vertices: points (n, 3), triangles."""
    body = raw_sphere(n)
    points = np.empty((n, 3))
    points[body.triangles] = body.shape(body.corners)
    return points, body.triangles


def interpolated(
    points: np.ndarray, triangles: np.ndarray, degree: int, onto: Callable
) -> tuple[TriangleSurface, np.ndarray]:
    """Bezier triangles through ``onto(x)`` at the lattices of flat triangles, and coefficients."""
    surface = TriangleSurface(triangles, degree)
    xi, eta, _ = lattice("triangle", degree)
    corners = np.stack([1.0 - xi - eta, xi, eta], axis=1)
    flat = np.einsum("kn,enc->ekc", corners, points[triangles])
    return surface, surface.coefficients_of(surface.interpolation(onto(flat)))


def regular_share(triangles: np.ndarray) -> float:
    """Share of the vertices with six triangles."""
    return float(np.mean(np.bincount(triangles.ravel()) == 6))
