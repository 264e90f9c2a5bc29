"""Reduced membrane quadrature over whole surfaces: the remedy against membrane locking.

In each direction the fewest points that integrate the spline space of degree p + 1 and
continuity p - 2 exactly: about 1.5 an element instead of p + 1, hence few enough strains that
must vanish in thin shells. Bending keeps its Gauss points, and as only a quadrature changes the
energy keeps its exact gradient and symmetric tangent. Periodic rules repeat after two elements:
one point each leaves the shortest wrinkles without membrane strain, two lock as Gauss points do.

Source of the idea: reduced rules for splines, Adam, Hughes et al. (2015), Leonetti et al. (2018);
points by Newton's method on the moments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .splines import SplineSpace, bernstein
from .surface import Surface
from .tensor_surface import TensorSurface


def reduced_rule(space: SplineSpace) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights on the whole of a spline space.

    Parameters
    ----------
    space : SplineSpace
        Degree p >= 2.

    Returns
    -------
    points, weights : (n,) arrays
        Exact on degree p + 1 splines with two more knots at each break.

    Raises
    ------
    ValueError
        If Newton's method finds no rule with positive weights inside (wildly graded breaks).
    """
    q = space.degree + 1
    target = SplineSpace(space.breaks, q, space.periodic, np.minimum(space.multiplicity + 2, q))
    moments = _moments(target)
    start, end = space.breaks[[0, -1]]
    groups = np.arange(target.n) // 2
    weights = np.bincount(groups, moments)
    points = np.bincount(groups, target.greville * moments) / weights

    def inside(x: np.ndarray) -> np.ndarray:
        return start + (x - start) % (end - start) if space.periodic else np.clip(x, start, end)

    points = inside(points)
    for _ in range(50):
        values, slopes = target.evaluate(points).T, target.evaluate(points, 1).T
        defect = values @ weights - moments
        if np.abs(defect).max() <= 1e-14 * (end - start):
            break
        step = np.linalg.lstsq(np.hstack([slopes * weights, values]), -defect, rcond=1e-12)[0]
        points, weights = inside(points + step[: points.size]), weights + step[points.size :]
    if np.abs(defect).max() > 1e-11 * (end - start) or weights.min() <= 0.0:
        raise ValueError(
            "no reduced membrane rule for these breaks: grade them less, or use membrane='gauss'"
        )
    order = np.argsort(points)
    return points[order], weights[order]


def _moments(space: SplineSpace) -> np.ndarray:
    """Integrals of all functions of a space."""
    x, w = np.polynomial.legendre.leggauss(space.degree + 1)
    h = np.diff(space.breaks)
    points = space.breaks[:-1, None] + 0.5 * h[:, None] * (x + 1.0)
    return (0.5 * h[:, None] * w).ravel() @ space.evaluate(points.ravel())


def _by_element(space: SplineSpace) -> tuple[np.ndarray, np.ndarray]:
    """Rule as local points and weights ``(n_elements, k)``, padded with zero weights."""
    points, weights = reduced_rule(space)
    e = np.clip(np.searchsorted(space.breaks, points, side="right") - 1, 0, space.n_elements - 1)
    count = np.bincount(e, minlength=space.n_elements)
    rank = np.arange(e.size) - np.concatenate([[0], np.cumsum(count)])[e]
    xi, w = np.full((space.n_elements, count.max()), 0.5), np.zeros((space.n_elements, count.max()))
    xi[e, rank] = (points - space.breaks[e]) / np.diff(space.breaks)[e]
    w[e, rank] = weights
    return xi, w


@dataclass(frozen=True)
class MembranePoints:
    """Basis functions and reference at the rule's points.

    Attributes
    ----------
    grads : (2, n_functions, n_elements, n_points) array
    reference : (2, n_elements, n_points, 3) array
        Tangents of the reference.
    dx : (n_elements, n_points) array
        Reference area of each point; zero where padded.
    """

    grads: np.ndarray
    reference: np.ndarray
    dx: np.ndarray


def membrane_points(surface: Surface, reference: np.ndarray | Callable) -> MembranePoints:
    """The rule on a surface, or on a block of its elements.

    Raises
    ------
    ValueError
        Triangles, elements that are not a block, or a rule that does not exist.
    """
    if not isinstance(surface, TensorSurface):
        raise ValueError("triangles have no reduced membrane rule: use membrane='gauss'")
    es, et = np.divmod(surface.selected, surface.t.n_elements)
    rows, columns = np.unique(es), np.unique(et)
    if rows.size * columns.size != es.size:
        raise ValueError("the reduced membrane rule needs a rectangular block of elements")
    (xs, ws), (xt, wt) = (
        _by_element(_part(space, chosen))
        for space, chosen in ((surface.s, rows), (surface.t, columns))
    )
    i, j = np.searchsorted(rows, es), np.searchsorted(columns, et)
    shape = (es.size, xs.shape[1] * xt.shape[1])
    xi = np.broadcast_to(xs[i][:, :, None], (es.size, xs.shape[1], xt.shape[1])).reshape(shape)
    eta = np.broadcast_to(xt[j][:, None, :], (es.size, xs.shape[1], xt.shape[1])).reshape(shape)
    weights = (ws[i][:, :, None] * wt[j][:, None, :]).reshape(shape)
    hs, ht = np.diff(surface.s.breaks)[es], np.diff(surface.t.breaks)[et]
    p = surface.degree

    def along(a: int, b: int) -> np.ndarray:
        product = bernstein(p, xi, a)[:, None] * bernstein(p, eta, b)[None]
        local = np.moveaxis(product.reshape(-1, *shape), 1, 0)
        values = surface.tables @ local / (hs**a * ht**b)[:, None, None]
        return np.swapaxes(values, 0, 1)

    grads = np.stack([along(1, 0), along(0, 1)])
    if callable(reference):
        s = surface.s.breaks[es][:, None] + hs[:, None] * xi
        t = surface.t.breaks[et][:, None] + ht[:, None] * eta
        tangents = np.stack(reference(s, t)[1])
    else:
        local = np.asarray(reference)[surface.element_dofs]
        tangents = np.einsum("daeq,eac->deqc", grads, local, optimize=True)
    area = np.linalg.norm(np.cross(*tangents), axis=-1)
    return MembranePoints(grads, tangents, area * weights)


def _part(space: SplineSpace, chosen: np.ndarray) -> SplineSpace:
    """The space on consecutive elements."""
    if chosen.size == space.n_elements:
        return space
    if chosen[-1] - chosen[0] + 1 != chosen.size:
        raise ValueError("the reduced membrane rule needs a rectangular block of elements")
    cut = slice(chosen[0], chosen[-1] + 2)
    multiplicity = space.multiplicity[cut].copy()
    multiplicity[[0, -1]] = 1
    return SplineSpace(space.breaks[cut], space.degree, multiplicity=multiplicity)
