"""Local coordinates of elements: Bernstein functions, lattices and rules of squares and triangles.

Squares have ``0 <= xi, eta <= 1``. Triangles have ``u = 1 - xi - eta, v = xi, w = eta`` and the
functions ``p! / (a! b! c!) u^a v^b w^c``, vertex u = 1 first, then row by row towards the opposite
edge: (p, 0, 0), (p - 1, 1, 0), (p - 1, 0, 1), ...
"""

from __future__ import annotations

from functools import cache
from math import factorial
from typing import NamedTuple

import numpy as np

from .splines import bernstein, unit_gauss


class Lattice(NamedTuple):
    """Points ``xi, eta (n,)`` of one element and the cells ``(m, 4)`` or ``(m, 3)`` between."""

    xi: np.ndarray
    eta: np.ndarray
    cells: np.ndarray


class Rule(NamedTuple):
    """Quadrature points ``xi, eta (n,)`` of one element and weights, which sum to its area."""

    xi: np.ndarray
    eta: np.ndarray
    weights: np.ndarray


def triangle_exponents(degree: int) -> np.ndarray:
    """Exponents ``(a, b, c)`` of the functions of a triangle, ``(n, 3)``, in order."""
    return np.array([(degree - i, i - j, j) for i in range(degree + 1) for j in range(i + 1)])


def functions(
    shape: str, degree: int, xi: np.ndarray, eta: np.ndarray, derivative: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """Bernstein functions of an element, or a derivative of them, ``(n_points, n_functions)``.

    Parameters
    ----------
    shape : {"quadrilateral", "triangle"}
    degree : int
    xi, eta : (n_points,) array
    derivative : (int, int)
        How often along xi and eta.
    """
    i, j = derivative
    if shape == "triangle":
        return _triangle(degree, np.asarray(xi, float), np.asarray(eta, float), i, j)
    values = bernstein(degree, xi, i)[:, None] * bernstein(degree, eta, j)
    return values.reshape(-1, np.size(xi)).T


def _triangle(degree: int, xi: np.ndarray, eta: np.ndarray, i: int, j: int) -> np.ndarray:
    exponents = triangle_exponents(degree)
    if i + j > degree:
        return np.zeros((xi.size, len(exponents)))
    if i or j:
        # d/dxi B_abc = p (B_{a, b-1, c} - B_{a-1, b, c}), of degree p - 1; likewise along eta
        lower = _triangle(degree - 1, xi, eta, i - bool(i), j - (not i))
        place = {tuple(e): k for k, e in enumerate(triangle_exponents(degree - 1).tolist())}
        out = np.zeros((xi.size, len(exponents)))
        for k, (a, b, c) in enumerate(exponents.tolist()):
            gained = (a, b - 1, c) if i else (a, b, c - 1)
            for sign, e in ((1, gained), (-1, (a - 1, b, c))):
                if e in place:
                    out[:, k] += sign * degree * lower[:, place[e]]
        return out
    u, v, w = 1.0 - xi - eta, xi, eta
    count = [factorial(degree) / (factorial(a) * factorial(b) * factorial(c))
             for a, b, c in exponents.tolist()]  # fmt: skip
    a, b, c = exponents.T
    return np.array(count) * u[:, None] ** a * v[:, None] ** b * w[:, None] ** c


@cache
def lattice(shape: str, cells: int) -> Lattice:
    """An even lattice of ``cells`` cells along each side, row by row."""
    n = cells + 1
    i, j = (g.ravel() for g in np.meshgrid(range(cells), range(cells), indexing="ij"))
    if shape == "triangle":
        xi, eta = np.array([(b, c) for _, b, c in triangle_exponents(cells)]).T / cells

        def number(row: np.ndarray, place: np.ndarray) -> np.ndarray:
            return row * (row + 1) // 2 + place

        up, down = j <= i, j < i
        outer = [number(i, j), number(i + 1, j), number(i + 1, j + 1)]
        inner = [number(i, j), number(i + 1, j + 1), number(i, j + 1)]
        triangles = [np.stack(t, axis=1)[k] for t, k in ((outer, up), (inner, down))]
        return Lattice(xi, eta, np.concatenate(triangles))
    x = np.linspace(0.0, 1.0, n)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    quads = np.stack([i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1], axis=1)
    return Lattice(xi, eta, quads)


@cache
def rule(shape: str, points: int) -> Rule:
    """A Gauss rule of ``points`` points each way, of triangles about the vertex u = 1."""
    x, w = unit_gauss(points)
    s, t = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    weights = np.outer(w, w).ravel()
    if shape == "triangle":
        return Rule(s * (1.0 - t), s * t, weights * s)
    return Rule(s, t, weights)


def middle(shape: str) -> tuple[np.ndarray, np.ndarray, float]:
    """The middle ``xi, eta (1,)`` of an element and the area of its local coordinates."""
    x = np.array([1.0 / 3.0 if shape == "triangle" else 0.5])
    return x, x, 0.5 if shape == "triangle" else 1.0
