"""Exact forces and tractions of unit spheres and of spheroids, per viscosity."""

from __future__ import annotations

import numpy as np

TERMS = 40.0  # exponent to which terms of a series have decayed at the last one


def approaching(gap: float) -> float:
    """Force on each of two unit spheres that approach with unit velocities, over ``6 pi``.

    The series of H. Brenner, Chem. Eng. Sci. 16 (1961), in bispherical coordinates; near contact
    ``1 / (2 gap) - 0.45 ln gap + 1.346``.
    """
    weight, m, alpha, e = _terms(gap)
    # numerator and denominator over exp(m alpha), which overflows
    above = 1.0 + e * e + (2.0 + (m * np.sinh(alpha)) ** 2) * e
    below = 1.0 - e * e - m * np.sinh(2.0 * alpha) * e
    return float(weight @ (above / below - 1.0))


def following(gap: float) -> float:
    """Force on each of two unit spheres that move after each other, over ``6 pi``.

    The series of M. Stimson and G. B. Jeffery, Proc. R. Soc. A 111 (1926); 0.645 at contact.
    """
    weight, m, alpha, e = _terms(gap)
    above = 1.0 + e * e - (2.0 + (m * np.sinh(alpha)) ** 2) * e
    below = 1.0 - e * e + m * np.sinh(2.0 * alpha) * e
    return float(weight @ (1.0 - above / below))


def _terms(gap: float) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Weights, ``2 n + 1``, alpha and ``exp(-(2 n + 1) alpha)`` of the terms n = 1, 2, ..."""
    alpha = float(np.arccosh(1.0 + 0.5 * gap))
    n = np.arange(1.0, TERMS / alpha + 10.0)
    weight = 4.0 / 3.0 * np.sinh(alpha) * n * (n + 1.0) / ((2.0 * n - 1.0) * (2.0 * n + 3.0))
    m = 2.0 * n + 1.0
    return weight, m, alpha, np.exp(-m * alpha)


def sphere_in(gradient: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Traction jump of a unit sphere whose surface moves with ``u = gradient x``, no trace."""
    strain, spin = 0.5 * (gradient + gradient.T), 0.5 * (gradient - gradient.T)
    return normals @ (5.0 * strain + 3.0 * spin).T


def spheroid_moving(
    c: float, velocity: np.ndarray, points: np.ndarray, normals: np.ndarray
) -> np.ndarray:
    """Traction of an oblate spheroid, radius 1 and half height c < 1, in translation.

    The force over the volume times a third of the distance of the tangent plane; its forces as in
    S. Kim and S. J. Karrila, Microhydrodynamics (1991), table 3.4.
    """
    e = np.sqrt(1.0 - c * c)
    cot = np.arctan2(e, c)
    along = 4.0 / 3.0 * e**3 / ((2.0 * e * e - 1.0) * cot + e * c)
    across = 8.0 / 3.0 * e**3 / ((2.0 * e * e + 1.0) * cot - e * c)
    force = 6.0 * np.pi * np.array([across, across, along]) * velocity
    return np.sum(normals * points, axis=1)[:, None] * force / (4.0 * np.pi * c)
