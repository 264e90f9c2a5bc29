"""Exact closed bodies for verification: sphere, spheroid and torus as degree-8 Bezier patches.

Geometry is interpolated at Chebyshev points (error below 1e-9 of the body, asserted); densities
are B-splines on an n_s x n_t grid, periodic in t. Poles: all functions of the first ring merged
into one (``"merged"``, continuous), or two rings from three functions (``"c1"``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq
from scipy.sparse import csr_matrix, identity, kron
from scipy.sparse.linalg import spsolve

from hbem.surfaces.bernstein import bernstein, tensor_bernstein
from hbem.surfaces.patches import BezierPatches
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace

from .body_splines import LineSplines, chebyshev, density, pole_reduction

DEGREE = 8
FIT = 1e-9  # largest accepted geometry error, relative to the body
Shape = Callable[[np.ndarray, np.ndarray], np.ndarray]


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
    pole_row: float | None = None,
) -> BezierPatches:
    """Spheroid of radius a and half height c.

    Parameters
    ----------
    n_s, n_t : int
        Elements from the upper pole down, and around.
    a, c : float
    degree : int
        Of the density.
    pole : {"merged", "c1"}
    grading : float
        In [0, 1), clusters elements at the rim: polar angle ``theta = x + grading / 2 sin 2x``, x
        uniform.
    pole_row : float, optional
        Angle of the first row of elements at the upper pole: rows grow geometrically from there to
        the lower pole. A film of thickness g between bodies of radius R needs rows of about half
        of ``sqrt(R g)``.

    Raises
    ------
    ValueError
        A row that is not positive or above the even one, or gradings at rim and pole at once.
    """
    if pole_row is not None and (grading or not 0.0 < pole_row <= np.pi / n_s):
        raise ValueError(
            f"pole_row must lie in (0, pi / n_s = {np.pi / n_s:.3g}] without a grading at the rim, "
            f"got {pole_row:g} and {grading:g}"
        )

    def shape(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        x, phi = np.pi * s, 2.0 * np.pi * t
        theta = x + 0.5 * grading * np.sin(2.0 * x)
        if pole_row is not None:
            theta = np.pi * _geometric(s, n_s, pole_row / np.pi)
        rho = a * np.sin(theta)
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), c * np.cos(theta)], axis=-1)

    return closed_body(shape, n_s, n_t, degree=degree, pole=pole)


def _geometric(s: np.ndarray, n: int, first: float) -> np.ndarray:
    """A smooth map of [0, 1] to itself that grows like a geometric series: ``1 / n`` to first."""

    def growth(rate: float) -> float:
        return float(np.expm1(rate / n) / np.expm1(rate)) - first

    if n * first >= 1.0 - 1e-9:
        return s
    rate = brentq(growth, 1e-9, 600.0)
    return np.expm1(rate * s) / np.expm1(rate)


def sphere(
    n_s: int,
    n_t: int,
    *,
    radius: float = 1.0,
    degree: int = 2,
    pole: str = "merged",
    pole_row: float | None = None,
) -> BezierPatches:
    """Sphere with n_s elements from pole to pole and n_t around.

    ``pole_row`` is the angle of the first row at the upper pole, see `spheroid`; default even rows.
    """
    return spheroid(n_s, n_t, a=radius, c=radius, degree=degree, pole=pole, pole_row=pole_row)


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
