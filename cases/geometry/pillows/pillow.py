"""Closed bags on the pillow basis: round and rounded-rectangle bags, flat or folded.

The base body is an ellipsoid, exact and smooth at the corners: with ``a = -cos pi t``,
``b = cos 2 pi s`` the point ``(a sqrt(1 - b^2/2), b sqrt(1 - a^2/2), sin pi t sin 2 pi s)`` lies
on the unit sphere. Plan, sheets and folds are maps of space applied to it; the result is fitted
to the basis in the L2 sense, corners kept smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import splu

from hbem.surfaces.patches import BezierPatches
from shells.surfaces.pillow import Pillow

from ..fold import PlanarCurve, zigzag

Map = Callable[[np.ndarray], np.ndarray]
FLATTEN = 3.0  # of the sheets: 0 keeps the ellipsoid
CORNERS = 0.3  # of a rounded rectangle: 0 keeps the disc
FIT_POINTS = 4  # Gauss points per direction and element
# of normal equations: five times faster than for a general matrix
SYMMETRIC: Mapping[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


def sphere_points(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points of the unit sphere at pillow parameters: ``(*s.shape, 3)``, ``d_s x d_t`` outward."""
    a, b = -np.cos(np.pi * t), np.cos(2.0 * np.pi * s)
    x, y = a * np.sqrt(1.0 - 0.5 * b * b), b * np.sqrt(1.0 - 0.5 * a * a)
    return np.stack([x, y, np.sin(np.pi * t) * np.sin(2.0 * np.pi * s)], axis=-1)


def flattened(height: float, k: float = FLATTEN) -> Map:
    """Scale z of a unit body to half the thickness ``height``, the more evenly the larger k."""

    def shape(x: np.ndarray) -> np.ndarray:
        z = x[:, 2] * np.sqrt((1.0 + k * k) / (1.0 + (k * x[:, 2]) ** 2))
        return np.column_stack([x[:, :2], height * z])

    return shape


def rectangle(length: float, width: float, corners: float = CORNERS) -> Map:
    """Unit disc plan to a rounded rectangle ``length x width``, x from 0 to ``length``."""

    def shape(x: np.ndarray) -> np.ndarray:
        u = x[:, 0] * (1.0 + corners * x[:, 1] ** 2)
        v = x[:, 1] * (1.0 + corners * x[:, 0] ** 2)
        return np.column_stack([0.5 * length * (1.0 + u), 0.5 * width * v, x[:, 2]])

    return shape


def square(x: np.ndarray) -> np.ndarray:
    """Unit sphere to a bag of exactly square plan, x from 0 to 1: ``((1 + a)/2, b/2, z)``.

    a, b are those of `sphere_points`, found again from x and y. The basis is smooth where the
    square has corners: its fit rounds them (largest distance 7e-3, 3e-3, 1.7e-3 for 32, 48, 64
    elements around).
    """
    u, v = x[:, 0] ** 2, x[:, 1] ** 2
    difference = u - v  # a^2 - b^2
    # a^2 is the smaller root of A^2 / 2 - A (1 + d/2) + u = 0, without cancellation
    plus, minus = 1.0 + 0.5 * difference, 1.0 - 0.5 * difference
    root = np.sqrt(np.maximum(plus**2 - 2.0 * u, 0.0))
    a, b = np.sqrt(2.0 * u / (plus + root)), np.sqrt(2.0 * v / (minus + root))
    flat = np.column_stack([np.copysign(a, x[:, 0]), np.copysign(b, x[:, 1])])
    return np.column_stack([0.5 * (1.0 + flat[:, 0]), 0.5 * flat[:, 1], x[:, 2]])


@dataclass(frozen=True)
class PillowBag:
    """A bag on the pillow basis.

    Attributes
    ----------
    surface : Pillow
    coefficients : (n_coefficients, 3) array
    gap, extent : float
        Sheet distance H and lateral extent l of the narrowest region.
    fit_error : float
        Largest distance of the fit from the exact surface at check points.
    """

    surface: Pillow
    coefficients: np.ndarray
    gap: float
    extent: float
    fit_error: float

    def patches(self) -> BezierPatches:
        """The bag as patches with its configuration, for the boundary integrals alone."""
        p = self.surface
        return BezierPatches(
            p.n_dofs, 2, 2, p.indptr, p.dofs, p.extraction, p.bezier, self.coefficients
        )


def fit(surface: Pillow, *maps: Map) -> tuple[np.ndarray, float]:
    """Coefficients ``(n, 3)`` of the unit sphere sent through maps, and the largest error."""
    x, w = np.polynomial.legendre.leggauss(FIT_POINTS)
    weights = np.tile(np.outer(w, w).ravel(), surface.n_elements)
    points, target = _samples(surface, 0.5 * (x + 1.0), maps)
    basis = points @ surface.reduction
    normal = (basis.T @ diags(weights) @ basis).tocsc()
    free = splu(normal, **SYMMETRIC).solve(basis.T @ (weights[:, None] * target))
    coefficients = surface.reduction @ free
    points, target = _samples(surface, np.linspace(0.0, 1.0, 3), maps)
    return coefficients, float(np.linalg.norm(points @ coefficients - target, axis=1).max())


def _samples(
    surface: Pillow, x: np.ndarray, maps: tuple[Map, ...]
) -> tuple[csr_matrix, np.ndarray]:
    """Evaluation matrix at tensor points ``x`` of every element, and the exact surface there."""
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    return surface.sample(xi, eta), exact_points(surface, x, maps)


def exact_points(surface: Pillow, x: np.ndarray, maps: tuple[Map, ...]) -> np.ndarray:
    """The unit sphere sent through maps, at tensor points ``x`` of every element."""
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    es, et = np.divmod(surface.selected, surface.n_t)
    s = ((es[:, None] + xi) / surface.n_s).ravel()
    t = ((et[:, None] + eta) / surface.n_t).ravel()
    target = sphere_points(s, t)
    for shape in maps:
        target = shape(target)
    return target


def round_bag(n_s: int, *, gap: float, flatten: float = FLATTEN) -> PillowBag:
    """Disc bag of radius 1 with sheets ``2 * gap`` apart at the middle, ``n_s x n_s / 2`` elements.

    ``gap`` is half the sheet distance over the radius; ``flatten = 0`` gives an ellipsoid.
    """
    surface = Pillow(n_s, n_s // 2)
    coefficients, error = fit(surface, flattened(gap, flatten))
    return PillowBag(surface, coefficients, 2.0 * gap, 1.0, error)


def square_bag(n_s: int, *, gap: float, flatten: float = FLATTEN) -> PillowBag:
    """Bag of unit square plan with sheets ``gap`` apart at the middle, ``n_s x n_s / 2`` elements.

    The start of an airbag test: two square sheets sewn together along the edge.
    """
    surface = Pillow(n_s, n_s // 2)
    coefficients, error = fit(surface, flattened(0.5 * gap, flatten), square)
    return PillowBag(surface, coefficients, gap, 0.5, error)


def unit_sphere(n_s: int) -> PillowBag:
    """The unit sphere on the pillow basis: no gap, for verification."""
    surface = Pillow(n_s, n_s // 2)
    coefficients, error = fit(surface)
    return PillowBag(surface, coefficients, 2.0, 1.0, error)


def accordion(
    n_s: int,
    folds: int,
    *,
    panel: float = 10.0,
    gap: float = 0.4,
    width: float | None = None,
    flatten: float = FLATTEN,
    size: float = 1.0,
) -> PillowBag:
    """Square bag folded ``folds`` times; its unfolded length is ``size``.

    Parameters
    ----------
    n_s : int
        Elements around; half as many across.
    panel, gap : float
        Panel length and sheet distance in units of the fold radius.
    width : float, optional
        Across the folds; default ``size``.

    Raises
    ------
    ValueError
        Sheets that would turn inside out (``gap / 2 < 1`` is needed) or panels too short.
    """
    if not 0.0 < gap < 2.0:
        raise ValueError(f"gap = {gap:g} fold radii: sheets turn inside out from 2 on")
    radius = size / ((folds + 1) * panel)
    curve: PlanarCurve = zigzag(folds, panel * radius, radius)
    surface = Pillow(n_s, n_s // 2)
    coefficients, error = fit(
        surface,
        flattened(0.5 * gap * radius, flatten),
        rectangle(size, size if width is None else width),
        curve.fold,
    )
    narrowest = min(gap, 2.0 - gap) * radius
    return PillowBag(surface, coefficients, narrowest, 0.5 * panel * radius, error)
