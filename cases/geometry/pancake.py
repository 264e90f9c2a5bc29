"""The pancake of [T fig. 6.4]: two flat sheets, a half-circle rim and a filleted neck, revolved.

Meridian by arclength from the top pole: sheet, rim (half circle of radius r), lower sheet, fillet
(concave quarter circle) down to the inflow rim at height 0. It is fitted by splines with knots at
its joints; the fit is the initial and the reference configuration of a run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from shells.conditions.supports import extraction
from shells.conditions.supports import rim as held_rim
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace

from .bag import Bag
from .revolution import revolve, ring_space

GRADING = 0.8  # largest growth of neighbouring element sizes along a sheet


@dataclass(frozen=True)
class Pancake:
    """Exact meridian: fold radius r, half width, neck radius, fillet radius."""

    radius: float
    half_width: float
    neck_radius: float
    fillet: float

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths of upper sheet, rim, lower sheet and fillet."""
        upper = self.half_width - self.radius
        lower = upper - self.neck_radius - self.fillet
        return np.array([upper, np.pi * self.radius, lower, 0.5 * np.pi * self.fillet])

    @cached_property
    def joints(self) -> np.ndarray:
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    def meridian(self, s: np.ndarray) -> np.ndarray:
        """Radius and height at arclength ``s (n,)``: ``(n, 2)``."""
        r, f = self.radius, self.fillet
        upper = self.half_width - r
        j = self.joints
        turn = (s - j[1]) / r
        bend = (s - j[3]) / f
        pieces = [
            (s, np.full_like(s, f + 2 * r)),
            (upper + r * np.sin(turn), f + r + r * np.cos(turn)),
            (upper - (s - j[2]), np.full_like(s, f)),
            (self.neck_radius + f - f * np.sin(bend), f * np.cos(bend)),
        ]
        piece = np.clip(np.searchsorted(j, s, side="right") - 1, 0, 3)
        rho = np.choose(piece, [p[0] for p in pieces])
        return np.stack([rho, np.choose(piece, [p[1] for p in pieces])], axis=1)

    @cached_property
    def volume(self) -> float:
        """Volume inside the membrane and the inflow disc, in closed form."""
        r, f, a = self.radius, self.fillet, self.neck_radius
        upper = self.half_width - r
        slab = 2 * r * np.pi * upper**2
        rim = 2 * np.pi * (upper + 4 * r / (3 * np.pi)) * 0.5 * np.pi * r**2
        b = a + f
        neck = np.pi * f * (b**2 - 0.5 * np.pi * b * f + 2.0 / 3.0 * f**2)
        return slab + rim + neck


def graded(length: float, first: float, last: float, largest: float) -> np.ndarray:
    """Breaks on [0, length]: sizes grow from both ends at rate `GRADING` up to ``largest``."""
    x, count = _counted(length, first, last, largest)
    n = graded_count(length, first, last, largest)
    return np.interp(np.linspace(0.0, count[-1], n + 1), count, x)


def graded_count(length: float, first: float, last: float, largest: float) -> int:
    """Elements of `graded`, without making them."""
    _, count = _counted(length, first, last, largest)
    return max(1, int(np.ceil(count[-1] - 1e-9)))


def _counted(
    length: float, first: float, last: float, largest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Places on [0, length] and the number of elements up to there."""
    x = np.linspace(0.0, length, 2001)
    size = np.minimum(largest, np.minimum(first + GRADING * x, last + GRADING * (length - x)))
    steps = np.diff(x) * 0.5 * (1.0 / size[1:] + 1.0 / size[:-1])
    return x, np.concatenate([[0.0], np.cumsum(steps)])


def meridian_rows(body: Pancake, rim: int, fillet: int, flat_max: float, pole: float) -> int:
    """Rows of elements of `meridian_breaks`, without making them."""
    lengths = body.lengths
    rim_size, fillet_size = lengths[1] / rim, lengths[3] / fillet
    upper = graded_count(lengths[0], pole, rim_size, flat_max)
    return upper + rim + graded_count(lengths[2], rim_size, fillet_size, flat_max) + fillet


def meridian_breaks(
    body: Pancake, rim: int, fillet: int, flat_max: float, pole: float
) -> tuple[np.ndarray, np.ndarray]:
    """Element boundaries along the meridian and the indices of its inner joints."""
    j, lengths = body.joints, body.lengths
    rim_size, fillet_size = lengths[1] / rim, lengths[3] / fillet
    parts = [
        graded(lengths[0], pole, rim_size, flat_max),
        j[1] + np.linspace(0.0, lengths[1], rim + 1)[1:],
        j[2] + graded(lengths[2], rim_size, fillet_size, flat_max)[1:],
        j[3] + np.linspace(0.0, lengths[3], fillet + 1)[1:],
    ]
    counts = np.cumsum([part.size for part in parts])
    return np.concatenate(parts), counts[:3] - 1


def _fit(body: Pancake, space: SplineSpace) -> tuple[np.ndarray, float]:
    """Meridian coefficients ``(n, 2)``: pole smooth, ends exact; and the largest error."""
    order = np.sort(
        np.concatenate(
            [
                space.breaks[:-1, None] + np.diff(space.breaks)[:, None] * g
                for g in [np.linspace(0.01, 0.99, 25)]
            ]
        ).ravel()
    )
    samples = body.meridian(order)
    start, end = space.evaluate(space.breaks[[0, -1]])
    slope = space.evaluate(space.breaks[:1], derivative=1)[0]
    tip = body.meridian(space.breaks[-1:])[0]
    free = np.nan
    constraints = [
        (start, np.array([0.0, free])),
        (slope, np.array([free, 0.0])),
        (end, tip),
    ]
    c = space.fit(samples, order, constraints)
    error = np.hypot(*(space.evaluate(order) @ c - samples).T).max()
    return c, float(error)


def pancake(
    body: Pancake,
    *,
    degree: int,
    around: int,
    rim: int,
    fillet: int,
    flat_max: float,
    pole: float,
    disc: int,
    double_joints: bool = False,
) -> Bag:
    """Fit the pancake by splines.

    Parameters
    ----------
    degree : {2, 3}
    around : int
        Elements in every ring.
    rim, fillet, disc : int
        Rows of elements on the rim, on the fillet and on the inflow disc.
    flat_max, pole : float
        Largest element on the sheets and size of the element at the pole.
    double_joints : bool
        Double knots where lines meet arcs: C1 there, where the exact curvature jumps.
    """
    t = ring_space(degree, around)
    breaks, joints = meridian_breaks(body, rim, fillet, flat_max, pole)
    multiplicity = np.ones(breaks.size, dtype=int)
    if double_joints:
        multiplicity[joints] = 2
    s = SplineSpace(breaks, degree, multiplicity=multiplicity)
    profile, error = _fit(body, s)
    inward = SplineSpace(np.linspace(0.0, body.neck_radius, disc + 1), degree)
    lid = np.stack([body.neck_radius - inward.greville, np.zeros(inward.n)], axis=1)
    radius = body.neck_radius

    def quadratic(points: np.ndarray) -> np.ndarray:
        return 1.0 - (points[:, 0] ** 2 + points[:, 1] ** 2) / radius**2

    membrane = SplineSurface(s, t, pole_start=True)
    inlet = SplineSurface(inward, t, pole_end=True)

    def support(kind: str) -> csr_matrix:
        fixed = held_rim(membrane, -1, kind)
        return extraction(membrane.reduction, fixed, inlet.n_coefficients)

    return Bag(
        membrane=membrane,
        inlet=inlet,
        coefficients=np.concatenate([revolve(profile, t), revolve(lid, t)]),
        support=support,
        profile=quadratic,
        gap=2.0 * body.radius,
        extent=body.half_width - body.radius,
        exact_volume=body.volume,
        fit_error=error,
    )
