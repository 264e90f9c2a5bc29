"""Exact closed bodies for verification: sphere, spheroid and torus as degree-8 Bezier patches.

Geometry is interpolated at Chebyshev points (error below 1e-9 of the body, asserted); densities
are B-splines on an n_s x n_t grid, periodic in t. Poles: all functions of the first ring merged
into one (``"merged"``, continuous), or two rings from three functions (``"c1"``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix, identity, kron
from scipy.sparse.linalg import spsolve

from hbem.surfaces.bernstein import bernstein, tensor_bernstein
from hbem.surfaces.patches import BezierPatches
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace

DEGREE = 8
FIT = 1e-9  # largest accepted geometry error, relative to the body
Shape = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class LineSplines:
    """Uniform B-splines on [0, 1]: open, or periodic."""

    n_elements: int
    degree: int
    periodic: bool

    @property
    def n(self) -> int:
        return self.n_elements + (0 if self.periodic else self.degree)

    @cached_property
    def knots(self) -> np.ndarray:
        n, p = self.n_elements, self.degree
        if self.periodic:
            return np.arange(-p, n + p + 1) / n
        return np.concatenate([np.zeros(p), np.arange(n + 1) / n, np.ones(p)])

    @cached_property
    def dofs(self) -> np.ndarray:
        """Functions of each element, ``(n_elements, degree + 1)``."""
        raw = np.arange(self.n_elements)[:, None] + np.arange(self.degree + 1)
        return raw % self.n

    @cached_property
    def extraction(self) -> np.ndarray:
        """Functions in Bernstein form, ``(n_elements, degree + 1, degree + 1)``."""
        p = self.degree
        x = chebyshev(p)
        points = (np.arange(self.n_elements)[:, None] + x) / self.n_elements
        raw = BSpline(self.knots, np.eye(self.knots.size - p - 1), p)(points)
        local = np.arange(self.n_elements)[:, None] + np.arange(p + 1)
        values = np.take_along_axis(raw, local[:, None, :], axis=2)
        tables = np.swapaxes(np.linalg.solve(bernstein(p, x), values), 1, 2)
        return np.where(np.abs(tables) < 1e-14, 0.0, tables)

    def greville_angle(self) -> np.ndarray:
        """Angles of the control points of a periodic circle."""
        return 2.0 * np.pi * (np.arange(self.n) - 0.5 * (self.degree - 1)) / self.n


def chebyshev(degree: int) -> np.ndarray:
    """Chebyshev points of the first kind on [0, 1], ``(degree + 1,)``."""
    return 0.5 - 0.5 * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def interpolate(shape: Shape, n_s: int, n_t: int) -> np.ndarray:
    """Bezier points ``(n_elements, 9, 9, 3)`` of a parametrised surface on [0, 1]^2.

    Raises
    ------
    AssertionError
        The interpolant misses the surface by more than 1e-9 of its size.
    """
    x = chebyshev(DEGREE)
    inverse = np.linalg.inv(bernstein(DEGREE, x))
    values = _on_elements(shape, n_s, n_t, x)
    control = np.einsum("ik,ekmc,jm->eijc", inverse, values, inverse, optimize=True)
    check = np.linspace(0.0, 1.0, 11)
    table = bernstein(DEGREE, check)
    exact = _on_elements(shape, n_s, n_t, check)
    error = np.abs(np.einsum("ki,eijc,mj->ekmc", table, control, table, optimize=True) - exact)
    assert error.max() < FIT * np.ptp(exact), f"geometry error {error.max():.1e}: refine the mesh"
    return control


def _on_elements(shape: Shape, n_s: int, n_t: int, x: np.ndarray) -> np.ndarray:
    i, j = np.divmod(np.arange(n_s * n_t), n_t)
    s = ((i[:, None] + x) / n_s)[:, :, None]
    t = ((j[:, None] + x) / n_t)[:, None, :]
    return shape(*np.broadcast_arrays(s, t))


def pole_reduction(s: LineSplines, t: LineSplines, pole: str) -> csr_matrix:
    """Tensor functions from dofs with both ends of s collapsed, ``(n_s n_t, n_dofs)``.

    Raises
    ------
    ValueError
        An unknown kind of pole.
    """
    if pole == "merged":
        end, rings = np.ones((t.n, 1)), 1
    elif pole == "c1":
        corners = 2.0 * np.pi * np.arange(3) / 3.0
        ring = (1.0 + np.cos(t.greville_angle()[:, None] - corners)) / 3.0
        end, rings = np.concatenate([np.full((t.n, 3), 1.0 / 3.0), ring]), 2
    else:
        raise ValueError(f"pole must be 'merged' or 'c1', got {pole!r}")
    k = end.shape[1]
    inner = (s.n - 2 * rings) * t.n
    full = np.zeros((s.n * t.n, inner + 2 * k))
    full[rings * t.n : rings * t.n + inner, k : k + inner] = np.eye(inner)
    for r in range(rings):
        block = end[r * t.n : (r + 1) * t.n]
        full[r * t.n : (r + 1) * t.n, :k] = block
        full[(s.n - 1 - r) * t.n : (s.n - r) * t.n, k + inner :] = block
    return csr_matrix(full)


def density(
    s: LineSplines, t: LineSplines, reduction: csr_matrix
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density tables ``indptr, dofs, extraction`` of the reduced tensor functions."""
    indptr, dofs, rows = [0], [], []
    nb = (s.degree + 1) ** 2
    for i in range(s.n_elements):
        for j in range(t.n_elements):
            tensor = np.einsum("ak,bl->abkl", s.extraction[i], t.extraction[j]).reshape(nb, nb)
            local = reduction[(s.dofs[i][:, None] * t.n + t.dofs[j]).ravel()]
            used = np.unique(local.indices)
            dofs.append(used)
            rows.append(local[:, used].T @ tensor)
            indptr.append(indptr[-1] + used.size)
    return np.array(indptr), np.concatenate(dofs), np.concatenate(rows)


def _body(
    control: np.ndarray, s: LineSplines, t: LineSplines, reduction: csr_matrix
) -> BezierPatches:
    coefficients = control.reshape(-1, 3)
    return BezierPatches(
        reduction.shape[1],
        DEGREE,
        s.degree,
        *density(s, t, reduction),
        identity(coefficients.shape[0], format="csr"),
        coefficients,
    )


def closed_body(
    shape: Shape, n_s: int, n_t: int, *, ends: str = "poles", degree: int = 2, pole: str = "merged"
) -> BezierPatches:
    """A closed surface from its parametrisation on [0, 1]^2, interpolated to 1e-9.

    Parameters
    ----------
    shape : callable
        ``s, t (...,)`` to points ``(..., 3)``; periodic in t, ``x_s x x_t`` outward.
    n_s, n_t : int
        Elements along s and around t.
    ends : {"poles", "periodic"}
        Both ends of s collapse to points, or meet each other.
    degree : int
        Of the density.
    pole : {"merged", "c1"}

    Raises
    ------
    AssertionError
        The mesh is too coarse for the shape.
    ValueError
        An unknown kind of ends or pole.
    """
    if ends not in ("poles", "periodic"):
        raise ValueError(f"ends must be 'poles' or 'periodic', got {ends!r}")
    s, t = LineSplines(n_s, degree, ends == "periodic"), LineSplines(n_t, degree, True)
    whole = identity(s.n * t.n, format="csr")
    reduction = pole_reduction(s, t, pole) if ends == "poles" else whole
    return _body(interpolate(shape, n_s, n_t), s, t, reduction)


def from_control_points(
    control: np.ndarray, *, ends: str = "poles", degree: int = 2
) -> BezierPatches:
    """A closed spline surface from control points ``(n_s, n_t, 3)``, periodic in t.

    With ``ends = "poles"`` the first and last ring of control points must each be one point.

    Raises
    ------
    ValueError
        An unknown kind of ends, too few points, or end rings that are not points.
    """
    control = np.asarray(control, dtype=float)
    if ends not in ("poles", "periodic"):
        raise ValueError(f"ends must be 'poles' or 'periodic', got {ends!r}")
    n_s, n_t, _ = control.shape
    closed = ends == "periodic"
    if not closed and np.ptp(control[[0, -1]], axis=1).max() > 1e-12 * np.ptp(control):
        raise ValueError(
            "with ends = 'poles' the first and last ring of control points must each be one "
            "point; repeat the pole, or use ends = 'periodic'"
        )
    rows = n_s if closed else n_s - degree
    s = SplineSpace(np.linspace(0.0, 1.0, rows + 1), degree, periodic=closed)
    t = SplineSpace(np.linspace(0.0, 1.0, n_t + 1), degree, periodic=True)
    p = SplineSurface(s, t, pole_start=not closed, pole_end=not closed)
    tables = (p.indptr, p.dofs, p.extraction, p.bezier)
    return BezierPatches(p.n_dofs, degree, degree, *tables, control.reshape(-1, 3))


def spheroid(
    n_s: int,
    n_t: int,
    *,
    a: float = 1.0,
    c: float = 1.0,
    degree: int = 2,
    pole: str = "merged",
    grading: float = 0.0,
) -> BezierPatches:
    """Spheroid of radius a and half height c; ``grading`` in [0, 1) clusters elements at the rim.

    Polar angle ``theta = x + grading / 2 sin 2x``, x uniform, from the upper pole down.
    """

    def shape(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        x, phi = np.pi * s, 2.0 * np.pi * t
        theta = x + 0.5 * grading * np.sin(2.0 * x)
        rho = a * np.sin(theta)
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), c * np.cos(theta)], axis=-1)

    return closed_body(shape, n_s, n_t, degree=degree, pole=pole)


def sphere(
    n_s: int, n_t: int, *, radius: float = 1.0, degree: int = 2, pole: str = "merged"
) -> BezierPatches:
    """Sphere with n_s elements from pole to pole and n_t around."""
    return spheroid(n_s, n_t, a=radius, c=radius, degree=degree, pole=pole)


def torus(
    n_s: int, n_t: int, *, minor: float = 1.0, major: float = 3.0, degree: int = 2
) -> BezierPatches:
    """Torus about the third axis; s turns around the tube, t around the axis."""

    def shape(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        theta, phi = 2.0 * np.pi * s, -2.0 * np.pi * t
        rho = major + minor * np.cos(theta)
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), minor * np.sin(theta)], axis=-1)

    return closed_body(shape, n_s, n_t, ends="periodic", degree=degree)


def fitted(body: BezierPatches, samples: int = 6) -> BezierPatches:
    """The isogeometric version of a body: geometry fitted in its own density space."""
    q = body.density_degree
    nb = (q + 1) ** 2
    x = chebyshev(samples - 1)
    s, t = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    element = np.repeat(np.arange(body.n_elements), np.diff(body.indptr))
    rows = element[:, None] * nb + np.arange(nb)
    columns = np.repeat(body.dofs, nb)
    shape = (body.n_elements * nb, body.n_dofs)
    bezier = csr_matrix((body.extraction.ravel(), (rows.ravel(), columns)), shape=shape)
    here = kron(identity(body.n_elements), tensor_bernstein(q, s, t), format="csr") @ bezier
    there = kron(identity(body.n_elements), tensor_bernstein(DEGREE, s, t), format="csr")
    target = here.T @ (there @ body.coefficients)
    coefficients = spsolve((here.T @ here).tocsc(), target)
    return replace(body, geometry_degree=q, bezier=bezier, coefficients=coefficients)
