"""Point clouds on which compression has failed elsewhere, all axis-aligned where flat.

With normals that suit them, and both kernels as dense matrices, written independently of `hbem`.
"""

from __future__ import annotations

import numpy as np


def sphere(n: int) -> np.ndarray:
    k = np.arange(n) + 0.5
    z, phi = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def grid(n: int, m: int) -> np.ndarray:
    x, y = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(m) + 0.5) / m, indexing="ij")
    return np.stack([x.ravel(), y.ravel()], axis=1)


def torus(n: int) -> np.ndarray:
    u, v = 2.0 * np.pi * grid(n, n // 2).T
    r = 1.0 + 0.4 * np.cos(v)
    return np.stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v)], axis=1)


def sheets(n: int, heights: tuple[float, ...]) -> np.ndarray:
    """Unit squares parallel to z = 0 at some heights: exactly coplanar clusters."""
    flat = grid(n, n)
    return np.concatenate([np.c_[flat, np.full(flat.shape[0], h)] for h in heights])


def stack(n: int) -> np.ndarray:
    """Ten layers with gaps of a hundredth."""
    return sheets(n, tuple(0.01 * np.arange(10)))


def pancake(n: int) -> np.ndarray:
    """Two discs, half gap 0.05, joined by a half-circular rim."""
    radius, angle = np.sqrt(grid(n, n)[:, 0]), 2.0 * np.pi * grid(n, n)[:, 1]
    disc = np.c_[radius * np.cos(angle), radius * np.sin(angle)]
    turn, around = grid(n // 4, 3 * n).T
    r = 1.0 + 0.05 * np.sin(np.pi * turn)
    rim = np.c_[r * np.cos(2 * np.pi * around), r * np.sin(2 * np.pi * around)]
    top, bottom = (np.c_[disc, np.full(disc.shape[0], z)] for z in (0.05, -0.05))
    return np.concatenate([top, bottom, np.c_[rim, 0.05 * np.cos(np.pi * turn)]])


def fold(n: int) -> np.ndarray:
    """Two unit squares that meet at a right angle."""
    flat = grid(n, n)
    zero = np.zeros(flat.shape[0])
    return np.concatenate([np.c_[flat, zero], np.c_[zero, flat]])


def line(n: int) -> np.ndarray:
    """Collinear points on the x axis."""
    return np.c_[(np.arange(n) + 0.5) / n, np.zeros((n, 2))]


def graded(n: int, spacing: float, depth: float = 0.05) -> np.ndarray:
    """A shallow bowl, or a plane, whose n lines each way crowd at a corner, from a spacing to 1."""
    ticks = np.append(0.0, np.geomspace(spacing, 1.0, n - 1))
    x, y = (g.ravel() for g in np.meshgrid(ticks, ticks, indexing="ij"))
    return np.c_[x, y, depth * (x * x + y * y)]


CLOUDS = {
    "sphere": sphere(900),
    "torus": torus(42),
    "pancake": pancake(17),
    "coplanar sheets": sheets(21, (0.0, 0.05)),
    "stack": stack(9),
    "fold": fold(21),
    "line": line(900),
}
GRADED = {
    "graded to 1e-5": graded(22, 1.2e-5),
    "graded to 5e-8": graded(22, 4.8e-8),
    # turned, its double layer is rounding of the coordinates
    "graded plane": graded(22, 1.2e-5, 0.0),
}


def normals(name: str, points: np.ndarray) -> np.ndarray:
    """Normals that suit the cloud: flat ones give exact zero blocks of the double layer."""
    n = points.shape[0]
    if name in ("coplanar sheets", "stack", *GRADED):
        return np.tile([0.0, 0.0, 1.0], (n, 1))
    if name == "fold":
        return np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], n // 2, axis=0)
    if name == "sphere":
        return points
    rough = np.random.default_rng(0).standard_normal((n, 3))
    return rough / np.linalg.norm(rough, axis=1, keepdims=True)


def dense(points: np.ndarray, directions: np.ndarray | None = None) -> np.ndarray:
    """The plain kernel as a matrix ``(3 n, 3 n)``, written independently of the package."""
    r = points[:, None, :] - points[None, :, :]
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    outer = r[:, :, :, None] * r[:, :, None, :]
    if directions is None:
        kernel = np.eye(3) / distance[:, :, None, None] + outer / distance[:, :, None, None] ** 3
        kernel /= 8.0 * np.pi
    else:
        flux = np.einsum("ijk,jk->ij", r, directions)
        kernel = 3.0 / (4.0 * np.pi) * outer * (flux / distance**5)[:, :, None, None]
    n = points.shape[0]
    return kernel.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
