"""Triangulations that tests start from: spheres raw and regular, and bodies of revolution."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from cases.geometry.meshes.facet_mesh import FacetMesh
from shells.surfaces.triangles.edge_graph import edge_graph


def icosphere(splits: int) -> FacetMesh:
    """20 * 4**splits triangles on the unit sphere."""
    long, short = 0.5 * (1.0 + 5.0**0.5), 1.0
    corner = np.array([[0.0, a, b] for a in (-short, short) for b in (-long, long)])
    points = np.concatenate([np.roll(corner, k, axis=1) for k in range(3)])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = outward(points)
    for _ in range(splits):
        graph = edge_graph(triangles)
        middle = len(points) + graph.of_triangle
        points = np.concatenate([points, points[graph.vertices].mean(axis=1)])
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        (a, b, c), (ab, bc, ca) = triangles.T, middle.T
        four = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        triangles = np.array(four).transpose(2, 0, 1).reshape(-1, 3)
    return FacetMesh(points, triangles)


@cache
def raw_sphere(n: int, seed: int = 0) -> FacetMesh:
    """Delaunay triangulation of n points that repel each other, 2 n - 4 triangles."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(n, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    for _ in range(80):
        d = p[:, None] - p
        force = np.sum(d / (np.sum(d**2, axis=2) + np.eye(n))[..., None] ** 2, axis=1)
        force -= np.sum(force * p, axis=1, keepdims=True) * p
        p += 0.3 * n**-0.5 * force / np.abs(force).max()
        p /= np.linalg.norm(p, axis=1, keepdims=True)
    return FacetMesh(p, outward(p))


def outward(points: np.ndarray) -> np.ndarray:
    """Triangles of the convex hull about the origin, counterclockwise from outside."""
    triangles = ConvexHull(points).simplices
    inward = np.linalg.det(points[triangles]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def revolved(radius: np.ndarray, height: np.ndarray, around: int) -> FacetMesh:
    """Rings of a meridian from the lower to the upper pole; a radius of 0 ends it in a point."""
    angle = 2.0 * np.pi * np.arange(around) / around
    points, rings = [], []
    for r, z in zip(radius, height, strict=True):
        count = 1 if r == 0.0 else around
        first = sum(map(len, points))
        rings.append(first + np.arange(around) % count)
        ring = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(around, z)], axis=1)
        points.append(ring[:count])
    triangles = []
    for low, up in pairwise(rings):
        on, above = np.roll(low, -1), np.roll(up, -1)
        triangles += [np.stack([low, on, above], axis=1), np.stack([low, above, up], axis=1)]
    t = np.concatenate(triangles)
    proper = (t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])
    return FacetMesh(np.concatenate(points), t[proper])


def without(mesh: FacetMesh, gone: np.ndarray) -> FacetMesh:
    """A mesh without some triangles (bool), and the points that only they had."""
    used, numbers = np.unique(mesh.triangles[~gone], return_inverse=True)
    return FacetMesh(mesh.points[used], numbers.reshape(-1, 3))


def pancake(around: int = 24) -> tuple[FacetMesh, float]:
    """A flat bag with a half-round rim, its inlet a disc of radius 1; and its exact volume."""
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)
    radius = np.r_[0.0, 0.5, 1.0, 2.0, 3.0, 4.0 + 0.5 * np.cos(turn), 3.0, 2.0, 1.0, 0.0]
    height = np.r_[np.full(5, -0.5), 0.5 * np.sin(turn), np.full(4, 0.5)]
    mesh = revolved(radius, height, around)
    low = mesh.points[mesh.triangles].mean(axis=1)
    inlet = np.flatnonzero((low[:, 2] < -0.49) & (np.hypot(low[:, 0], low[:, 1]) < 1.0))
    rest = np.setdiff1d(np.arange(len(mesh.triangles)), inlet)
    groups = {"Inlet": inlet, "membrane": rest}
    rim = 2.0 * np.pi * (4.0 + 4.0 * 0.5 / (3.0 * np.pi)) * 0.5 * np.pi * 0.5**2
    return FacetMesh(mesh.points, mesh.triangles, groups), 16.0 * np.pi + rim


@pytest.fixture(scope="session")
def bodies() -> SimpleNamespace:
    """What makes triangulations."""
    return SimpleNamespace(
        icosphere=icosphere,
        raw_sphere=raw_sphere,
        revolved=revolved,
        pancake=pancake,
        without=without,
    )
