"""Folded bags with an inlet: the flat and the folded bag fitted to one pillow basis.

The inlet is a square of whole elements on the lower sheet of an end panel. The membrane is the
rest; functions across the rim are cut in two. Both configurations share their coefficients'
numbering, so that a shell may take its metric from one and its curvature from the other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shells.conditions.supports import extraction
from shells.surfaces.pillow import Pillow

from ..bag import Bag
from ..folding import Folding, Map
from .crumple import crumple
from .pillow import exact_points, fit, flattened, rectangle, square

FLATTEN = 4.0  # evenness of the sheets: thickness at half the way to the rim 0.95 of the middle


def inlet_cells(surface: Pillow, x: float, size: int) -> np.ndarray:
    """A square of elements on the lower sheet, its middle near ``(x, 0)`` of the flat bag."""
    t = np.arccos(1.0 - 2.0 * x) / np.pi * surface.n_t
    s0 = round(0.75 * surface.n_s - 0.5 * size)
    t0 = int(np.clip(round(t - 0.5 * size), 1, surface.n_t - 1 - size))
    es, et = np.meshgrid(s0 + np.arange(size), t0 + np.arange(size), indexing="ij")
    return (es * surface.n_t + et).ravel()


def folded_bag(
    surface: Pillow,
    folding: Folding,
    *,
    plan: str = "rectangle",
    width: float = 1.0,
    inlet_elements: int = 2,
    crumpled: float = 0.0,
    seed: int = 0,
) -> Bag:
    """Fit a flat bag and its folded state, and cut out the inlet.

    Parameters
    ----------
    surface : Pillow
    folding : Folding
    plan : {"rectangle", "round", "square"}
        Outline of the flat bag, of unit length; rectangles have round corners, squares have not.
    width : float
        Of a rectangle.
    inlet_elements : int
        Elements along a side of the inlet.
    crumpled : float
        Amplitude of a random collision-free displacement after folding; 0 for none.
    seed : int
        Of the random displacement.

    Raises
    ------
    CrumpleError
        A bag to be crumpled that already touches itself.
    """
    base = outline(folding.gap, plan, width)
    flat_all, _ = fit(surface, *base)
    folded_all, error = fit(surface, *base, *folding.maps)
    cut = inlet_cells(surface, folding.inlet, inlet_elements)
    rest = np.setdiff1d(np.arange(surface.n_s * surface.n_t), cut)
    membrane, inlet = surface.restrict(rest), surface.restrict(cut)
    if crumpled > 0.0:
        folded_all = crumple(surface, folded_all, cut, amplitude=crumpled, seed=seed)
    parts = [np.concatenate([c[membrane.kept], c[inlet.kept]]) for c in (folded_all, flat_all)]
    exact = np.nan if crumpled else exact_volume(surface, (*base, *folding.maps))
    return Bag(
        membrane=membrane,
        inlet=inlet,
        coefficients=parts[0],
        support=lambda kind: extraction(membrane.held(kind), None, inlet.n_coefficients),
        profile=bubble(inlet, parts[0][membrane.n_coefficients :], inlet_elements),
        gap=min(folding.gap, folding.between),
        extent=0.5 * folding.panel,
        exact_volume=exact,
        fit_error=error,
        folding=folding,
        flat=parts[1],
    )


def outline(gap: float, plan: str, width: float) -> tuple[Map, ...]:
    """Maps from the unit sphere to the flat bag of unit length."""
    if plan == "round":
        return flattened(0.5 * gap, FLATTEN), rectangle(1.0, 1.0, corners=0.0)
    if plan == "square":
        return flattened(0.5 * gap, FLATTEN), square
    return flattened(0.5 * gap, FLATTEN), rectangle(1.0, width)


def exact_volume(surface: Pillow, maps: tuple[Map, ...], points: int = 7) -> float:
    """Volume inside the exact body [T 2.27], interpolated on each element at Gauss points."""
    x, w = np.polynomial.legendre.leggauss(points)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    powers = np.arange(points)
    slopes = powers * x[:, None] ** np.maximum(powers - 1, 0)
    derivative = slopes @ np.linalg.inv(x[:, None] ** powers)
    X = exact_points(surface, x, maps).reshape(-1, points, points, 3)
    s, t = np.einsum("ai,eijc->eajc", derivative, X), np.einsum("bj,eijc->eibc", derivative, X)
    cone = np.einsum("eijc,eijc->eij", X, np.cross(s, t)) / 3.0
    return float(np.einsum("eij,i,j->", cone, w, w))


def bubble(inlet: Pillow, coefficients: np.ndarray, size: int) -> Callable:
    """Inflow profile ``16 a (1 - a) b (1 - b)`` in inlet coordinates a, b, of points in space.

    A quartic in coordinates of the inlet's plane, fitted to the profile on the inlet; points of
    the inlet only may be asked for, and what the fit leaves below zero at the rim is cut off.
    """
    x = np.linspace(0.0, 1.0, 9)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    points = inlet.sample(xi, eta) @ coefficients
    es, et = np.divmod(inlet.selected, inlet.n_t)
    a = (((es - es.min())[:, None] + xi) / size).ravel()
    b = (((et - et.min())[:, None] + eta) / size).ravel()
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    scale = np.abs((points - centre) @ axes[:2].T).max(axis=0)

    def monomials(at: np.ndarray) -> np.ndarray:
        u, v = ((at - centre) @ axes[:2].T / scale).T
        return np.stack([u**i * v**j for i in range(5) for j in range(5)], axis=1)

    values = 16.0 * a * (1.0 - a) * b * (1.0 - b)
    weights = np.linalg.lstsq(monomials(points), values, rcond=None)[0]
    return lambda at: np.maximum(monomials(at) @ weights, 0.0)
