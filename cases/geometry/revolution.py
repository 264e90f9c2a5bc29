"""Surfaces of revolution: ring coefficients from a meridian, spheres and flat round bags."""

from __future__ import annotations

import numpy as np

from shells.surfaces.spline_surface import SplineSurface, ring_scale
from shells.surfaces.splines import SplineSpace


def revolve(profile: np.ndarray, t: SplineSpace) -> np.ndarray:
    """Coefficients ``(n * t.n, 3)`` of the surface of revolution of ``profile (n, 2)``."""
    angle = 2.0 * np.pi * (t.greville - t.breaks[0]) / (t.breaks[-1] - t.breaks[0])
    rho = profile[:, :1] / ring_scale(t)
    z = np.broadcast_to(profile[:, 1:], (profile.shape[0], t.n))
    return np.stack([rho * np.cos(angle), rho * np.sin(angle), z], axis=-1).reshape(-1, 3)


def ring_space(degree: int, around: int) -> SplineSpace:
    """Periodic space of the angle."""
    return SplineSpace(np.linspace(0.0, 2.0 * np.pi, around + 1), degree, periodic=True)


def sphere(degree: int, rows: int, around: int) -> tuple[SplineSurface, np.ndarray]:
    """Unit sphere as a spline surface with two poles, and its coefficients."""
    s = SplineSpace(np.linspace(0.0, np.pi, rows + 1), degree)
    x = np.linspace(0.0, np.pi, 40 * rows + 1)
    ends, slopes = s.evaluate(s.breaks[[0, -1]]), s.evaluate(s.breaks[[0, -1]], 1)
    held = [(row, np.array([0.0, np.nan])) for row in ends]
    held += [(row, np.array([np.nan, 0.0])) for row in slopes]
    profile = s.fit(np.stack([np.sin(x), np.cos(x)], axis=1), x, held)
    t = ring_space(degree, around)
    return SplineSurface(s, t, pole_start=True, pole_end=True), revolve(profile, t)


def flat_bag(degree: int, rows: int, around: int) -> tuple[SplineSurface, np.ndarray]:
    """Two flat unit discs sewn along their rim (a C0 seam), enclosing no volume."""
    breaks = np.linspace(0.0, 2.0, 2 * rows + 1)
    multiplicity = np.ones(breaks.size, dtype=int)
    multiplicity[rows] = degree
    s = SplineSpace(breaks, degree, multiplicity=multiplicity)
    x = np.linspace(0.0, 2.0, 40 * rows + 1)
    radius = s.fit((1.0 - np.abs(x - 1.0))[:, None], x)
    t = ring_space(degree, around)
    profile = np.concatenate([radius, np.zeros_like(radius)], axis=1)
    return SplineSurface(s, t, pole_start=True, pole_end=True), revolve(profile, t)
