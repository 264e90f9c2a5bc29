"""Bernstein polynomials and their tensor products on the unit square."""

from __future__ import annotations

from math import comb

import numpy as np


def bernstein(degree: int, x: np.ndarray) -> np.ndarray:
    """Bernstein polynomials at ``x (n,)``: ``(n, degree + 1)``, stable at any degree."""
    x = np.asarray(x, dtype=float)[:, None]
    values = np.ones((x.shape[0], 1))
    for _ in range(degree):
        zero = np.zeros((x.shape[0], 1))
        values = np.hstack([(1.0 - x) * values, zero]) + np.hstack([zero, x * values])
    return values


def bernstein_derivative(degree: int, x: np.ndarray) -> np.ndarray:
    """Derivatives of the Bernstein polynomials at ``x (n,)``: ``(n, degree + 1)``."""
    x = np.asarray(x, dtype=float)
    if degree == 0:
        return np.zeros((x.size, 1))
    lower = np.pad(bernstein(degree - 1, x), ((0, 0), (1, 1)))
    return degree * (lower[:, :-1] - lower[:, 1:])


def centred_powers(degree: int) -> np.ndarray:
    """Bernstein to coefficients of powers of ``2 x - 1``, power first, square.

    Centred powers cancel a thousand times less than powers of x at degree 8.
    """
    table = np.zeros((degree + 1, degree + 1))
    for j in range(degree + 1):
        # B_j = C(n, j) ((1 + z) / 2)^j ((1 - z) / 2)^(n - j)
        up = np.polynomial.polynomial.polypow([1.0, 1.0], j)
        down = np.polynomial.polynomial.polypow([1.0, -1.0], degree - j)
        table[:, j] = comb(degree, j) * np.polynomial.polynomial.polymul(up, down) / 2.0**degree
    return table


def tensor_bernstein(degree: int, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Values at paired local coordinates ``s, t (n,)``: ``(n, (degree + 1) ** 2)``."""
    return _outer(bernstein(degree, s), bernstein(degree, t))


def tensor_bernstein_gradient(
    degree: int, s: np.ndarray, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives along s and t at paired ``s, t (n,)``, each ``(n, (degree + 1) ** 2)``."""
    along_s = _outer(bernstein_derivative(degree, s), bernstein(degree, t))
    along_t = _outer(bernstein(degree, s), bernstein_derivative(degree, t))
    return along_s, along_t


def _outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a[:, :, None] * b[:, None, :]).reshape(a.shape[0], -1)
