"""Exact planar flows and shapes that benchmarks and tests measure against.

Polygons are ``(n, 2)``, counterclockwise; boundary data are given at both ends of each segment,
``(2 n, 2)``, in the order of the discontinuous linear functions.
"""

from __future__ import annotations

import numpy as np

from hbem.planar.polygon import edges, tested

QUADRILATERAL = np.array([[0.0, 0.0], [1.3, 0.1], [1.1, 0.9], [-0.2, 0.7]])


def quadrilateral(n: int) -> np.ndarray:
    """A convex quadrilateral with n segments on each side."""
    x = np.linspace(0.0, 1.0, n, endpoint=False)[:, None]
    return np.concatenate(
        [a + (b - a) * x for a, b in zip(QUADRILATERAL, np.roll(QUADRILATERAL, -1, 0), strict=True)]
    )


def slot(half_height: float, n: int, ends: int = 8) -> np.ndarray:
    """``(-1, 1) x (-H, H)``, n segments on each wall and ``ends`` on each side."""
    x, y = np.linspace(-1.0, 1.0, n + 1), np.linspace(-half_height, half_height, ends + 1)
    lower = np.column_stack([x[:-1], np.full(n, -half_height)])
    right = np.column_stack([np.ones(ends), y[:-1]])
    return np.concatenate([lower, right, -lower, -right])


def circle(radius: float, n: int) -> np.ndarray:
    """Regular polygon on a circle."""
    angle = 2.0 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def ends(points: np.ndarray) -> np.ndarray:
    """Both end points of each segment ``(2 n, 2)``."""
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1).reshape(-1, 2)


def quadratic_flow(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocity ``(y^2, x^2)`` with pressure ``2 x + 2 y`` and its stress ``(n, 2, 2)``, Re = 1."""
    stress = np.zeros((x.shape[0], 2, 2))
    stress[:, 0, 0] = stress[:, 1, 1] = -2.0 * x.sum(axis=1)
    stress[:, 0, 1] = stress[:, 1, 0] = 2.0 * x.sum(axis=1)
    return x[:, ::-1] ** 2, stress


def squeeze_film(x: np.ndarray, H: float, speed: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Two walls that approach each other, each with ``speed``: velocity and stress [T thm 33]."""
    c = 1.5 * speed / H**3
    X, Y = x.T
    velocity = c * np.column_stack([X * (H * H - Y * Y), Y * (Y * Y / 3.0 - H * H)])
    p = c * (Y * Y - X * X)
    stress = np.empty((X.size, 2, 2))
    stress[:, 0, 0] = -p + 2.0 * c * (H * H - Y * Y)
    stress[:, 1, 1] = -p + 2.0 * c * (Y * Y - H * H)
    stress[:, 0, 1] = stress[:, 1, 0] = -2.0 * c * X * Y
    return velocity, stress


def without_normal(points: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """Tractions ``(2 n, 2)`` less their pressure level: ``<tau, n> = 0``."""
    lengths, normals = edges(points)
    n = np.repeat(normals, 2, axis=0)
    level = float(np.sum(n * tested(lengths, traction))) / lengths.sum()
    return traction - level * n


def norm(points: np.ndarray, values: np.ndarray) -> float:
    """L2 norm of discontinuous linear values on the boundary."""
    lengths, _ = edges(points)
    return float(np.sqrt(np.sum(values * tested(lengths, values))))
