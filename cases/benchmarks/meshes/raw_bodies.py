"""Bodies on raw triangulations: smoothed Delaunay meshes, a third of whose vertices have valence 6.

What a mesh file looks like, for bodies whose flows are known: spheres, ellipsoids and a torus.
Geometry of Bezier triangles through exact points, or from the vertices' normals alone (PN patches
of A. Vlachos et al., I3D 2001), or flat facets; continuous densities of any degree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import ConvexHull, Delaunay

from hbem.surfaces.patches import BezierPatches
from shells.surfaces.local_elements import functions, triangle_exponents

SHAKEN = 1.5  # points of an even cover, by this part of their distance
SWEEPS = 12  # of smoothing: smallest angles of some 25 degrees
Shape = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class RawBody:
    """A triangulated body that knows its exact surface.

    Parameters
    ----------
    triangles : (n, 3) int array
        Vertices, counterclockwise from outside.
    corners : (n, 3, k) array
        Parameters of the vertices, by triangle: an angle may go on beyond a turn.
    shape, normal : callable
        Parameters ``(..., k)`` to points and outward unit normals ``(..., 3)``.
    """

    triangles: np.ndarray
    corners: np.ndarray
    shape: Shape
    normal: Shape

    @property
    def valence_six(self) -> float:
        """Share of vertices of valence 6."""
        return float(np.mean(np.bincount(self.triangles.ravel()) == 6))

    def patches(
        self, *, degree: int = 2, density: int = 1, from_normals: bool = False
    ) -> BezierPatches:
        """Bezier triangles with a continuous density.

        Parameters
        ----------
        degree : int
            Of the geometry; 1 are flat facets.
        density : int
        from_normals : bool
            Cubic patches from vertices and their normals instead of exact points.
        """
        control = self._from_normals() if from_normals else self._interpolated(degree)
        degree = 3 if from_normals else degree
        n_points, place = continuous(self.triangles, degree)
        n_dofs, dofs = continuous(self.triangles, density)
        coefficients = np.empty((n_points, 3))
        coefficients[place.ravel()] = control.reshape(-1, 3)
        rows = np.arange(place.size)
        return BezierPatches(
            n_dofs=n_dofs,
            geometry_degree=degree,
            density_degree=density,
            indptr=dofs.shape[1] * np.arange(len(dofs) + 1),
            dofs=dofs.ravel(),
            extraction=np.tile(np.eye(dofs.shape[1]), (len(dofs), 1)),
            bezier=csr_matrix((np.ones(place.size), (rows, place.ravel()))),
            coefficients=coefficients,
            shape="triangle",
        )

    def _interpolated(self, degree: int) -> np.ndarray:
        at = triangle_exponents(degree) / degree
        inverse = np.linalg.inv(functions("triangle", degree, at[:, 1], at[:, 2]))
        return inverse @ self.shape(at @ self.corners)

    def _from_normals(self) -> np.ndarray:
        vertices, normals = self.shape(self.corners), self.normal(self.corners)
        index = {tuple(e): k for k, e in enumerate(triangle_exponents(3).tolist())}
        control = np.empty((len(vertices), 10, 3))
        edges = np.zeros_like(vertices[:, 0])
        for i in range(3):
            control[:, index[tuple(3 * np.eye(3, dtype=int)[i])]] = vertices[:, i]
            for j in {0, 1, 2} - {i}:
                d = vertices[:, j] - vertices[:, i]
                rise = np.sum(d * normals[:, i], axis=1, keepdims=True)
                point = vertices[:, i] + (d - rise * normals[:, i]) / 3.0
                key = [0, 0, 0]
                key[i], key[j] = 2, 1
                control[:, index[tuple(key)]] = point
                edges += point / 6.0
        control[:, index[1, 1, 1]] = 1.5 * edges - 0.5 * vertices.mean(axis=1)
        return control

    def scaled(self, factors: np.ndarray) -> RawBody:
        """The body stretched along the axes: an ellipsoid from a sphere."""
        factors = np.asarray(factors, dtype=float)

        def normal(x: np.ndarray) -> np.ndarray:
            n = self.normal(x) / factors
            return n / np.linalg.norm(n, axis=-1, keepdims=True)

        return RawBody(self.triangles, self.corners, lambda x: self.shape(x) * factors, normal)


def continuous(triangles: np.ndarray, degree: int) -> tuple[int, np.ndarray]:
    """Number of continuous Bernstein functions, and those of each triangle ``(n, n_functions)``."""
    exponents = triangle_exponents(degree)
    key = np.where(exponents > 0, triangles[:, None] * (degree + 1) + exponents, -1)
    found, inverse = np.unique(np.sort(key, axis=2).reshape(-1, 3), axis=0, return_inverse=True)
    return len(found), inverse.reshape(len(triangles), -1)


def raw_sphere(n_vertices: int, seed: int = 0) -> RawBody:
    """Unit sphere; ``2 n_vertices - 4`` triangles."""
    x = _spiral(n_vertices)
    x += np.random.default_rng(seed).normal(size=x.shape) * SHAKEN / np.sqrt(n_vertices)
    for _ in range(SWEEPS):
        x = _unit(x - x.mean(axis=0))  # balanced: few points would gather on one side
        x = _smoothed(x, ConvexHull(x).simplices)
    x = _unit(x - x.mean(axis=0))
    triangles = ConvexHull(x).simplices.astype(np.int64)
    inward = np.linalg.det(x[triangles]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return RawBody(triangles, x[triangles], _unit, _unit)


def raw_ellipsoid(n_vertices: int, c: float, seed: int = 0) -> RawBody:
    """Oblate ellipsoid of radius 1 and half height c, of a stretched raw sphere."""
    return raw_sphere(n_vertices, seed).scaled(np.array([1.0, 1.0, c]))


def raw_torus(n_vertices: int, major: float = 2.0, minor: float = 1.0, seed: int = 0) -> RawBody:
    """Torus about the third axis, by conformal parameters: triangles keep their angles.

    The first is the angle about the axis, the second that about the tube at equal radii.
    """
    turn, root = 2.0 * np.pi, np.sqrt(major**2 - minor**2)
    size = np.array([1.0, minor / root])
    x = np.random.default_rng(seed).random((n_vertices, 2)) * turn
    for _ in range(SWEEPS):
        triangles, corners = _periodic(x, size)
        total, count = np.zeros_like(x), np.zeros(len(x))
        for k in (1, 2):
            np.add.at(total, triangles[:, 0], corners[:, k] - corners[:, 0])
            np.add.at(total, triangles[:, k], corners[:, 0] - corners[:, k])
            np.add.at(count, triangles[:, [0, k]], 1.0)
        x = (x + total / count[:, None]) % turn
    triangles, corners = _periodic(x, size)

    def normal(x: np.ndarray) -> np.ndarray:
        phi, psi = np.moveaxis(x, -1, 0)
        cosine = (major * np.cos(psi) - minor) / (major - minor * np.cos(psi))
        sine = root * np.sin(psi) / (major - minor * np.cos(psi))
        return np.stack([cosine * np.cos(phi), cosine * np.sin(phi), sine], axis=-1)

    def shape(x: np.ndarray) -> np.ndarray:
        phi = x[..., 0]
        ring = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=-1)
        return major * ring + minor * normal(x)

    return RawBody(triangles, corners, shape, normal)


def _spiral(n: int) -> np.ndarray:
    """Points that cover the unit sphere evenly."""
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    phi = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(n)
    rho = np.sqrt(1.0 - z * z)
    return np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=1)


def _unit(x: np.ndarray) -> np.ndarray:
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def _smoothed(x: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Every vertex half of the way to the mean of its neighbours."""
    pairs = np.concatenate([triangles[:, [i, j]] for i in range(3) for j in range(3) if i != j])
    total = np.zeros_like(x)
    np.add.at(total, pairs[:, 0], x[pairs[:, 1]])
    return 0.5 * (x + total / np.bincount(pairs[:, 0])[:, None])


def _periodic(x: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Delaunay triangulation of the torus of angles ``x (n, 2)``: triangles and their corners."""
    turn, n = 2.0 * np.pi, len(x)
    shifts = turn * np.array([(i, j) for i in (0, -1, 1) for j in (0, -1, 1)], dtype=float)
    copies = (x + shifts[:, None]).reshape(-1, 2)
    simplices = Delaunay(copies * size).simplices
    a, b, c = np.moveaxis(copies[simplices], 1, 0)
    clockwise = np.linalg.det(np.stack([b - a, c - a], axis=1)) < 0.0
    simplices[clockwise] = simplices[clockwise][:, ::-1]
    # one of all copies of a triangle: that whose middle lies in the first cell
    middle = copies[simplices].mean(axis=1)
    kept = np.all((middle >= 0.0) & (middle < turn), axis=1)
    return simplices[kept] % n, copies[simplices[kept]]
