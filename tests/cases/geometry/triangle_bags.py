"""A raw spheroid of cubic triangles with an inlet at its lower pole."""

import numpy as np
from scipy.spatial import ConvexHull

from cases.geometry.bag import Bag
from shells.conditions.supports import extraction, vector_dofs
from shells.surfaces.local_elements import lattice
from shells.surfaces.triangles.triangle_surface import TriangleSurface


def raw_sphere(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a spiral on the unit sphere and their triangles, seen from outside."""
    k = np.arange(n) + 0.5
    polar, around = np.arccos(1.0 - 2.0 * k / n), np.pi * (1.0 + 5.0**0.5) * k
    points = np.stack(
        [np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)], axis=1
    )
    triangles = ConvexHull(points).simplices
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles


def spheroid(n: int = 120, height: float = 0.5, degree: int = 3, inlet_below: float = -0.8) -> Bag:
    """Semi-axes 1, 1 and ``height``; triangles whose middle lies below are the inlet."""
    points, triangles = raw_sphere(n)
    below = points[triangles].mean(axis=1)[:, 2] < inlet_below
    parts, rows = [], []
    xi, eta, _ = lattice("triangle", degree)
    corners = np.stack([1.0 - xi - eta, xi, eta], axis=1)
    for mask in (~below, below):
        used, local = np.unique(triangles[mask], return_inverse=True)
        surface = TriangleSurface(local.reshape(-1, 3), degree)
        x = np.einsum("kn,enc->ekc", corners, points[used][surface.triangles])
        x /= np.linalg.norm(x, axis=2, keepdims=True)
        x *= [1.0, 1.0, height]
        parts.append(surface)
        rows.append(surface.coefficients_of(surface.interpolation(x)))
    membrane, inlet = parts
    fixed = vector_dofs(membrane.rim_coefficients)
    radius = np.sqrt(1.0 - inlet_below**2)
    return Bag(
        membrane=membrane,
        inlet=inlet,
        coefficients=np.concatenate(rows),
        support=lambda kind: extraction(membrane.reduction, fixed, inlet.n_coefficients),
        profile=lambda x: np.maximum(1.0 - (x[:, 0] ** 2 + x[:, 1] ** 2) / radius**2, 0.0),
        gap=2.0 * height,
        extent=1.0,
        exact_volume=4.0 / 3.0 * np.pi * height,
        fit_error=0.0,
    )
