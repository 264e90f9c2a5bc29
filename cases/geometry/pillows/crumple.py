"""Crumpling: random smooth displacements, each as far as it goes without contact.

``c <- c + 0.9 alpha D`` with the collision-free fraction alpha of a random Fourier displacement D
plus a contraction: the result never intersects itself. Needs the optional extra ``contact``.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from coupling.contact.sampled_mesh import SampledMesh, grid_cells
from shells.surfaces.pillow import Pillow

ROUNDS = 8
WAVES = 12  # Fourier modes of one displacement
SAMPLES = 3  # points per element side of the collision mesh
SHARE = 0.9  # of the collision-free step


class CrumpleError(ValueError):
    """A bag that cannot be crumpled."""


def sampled(surface: Pillow, coefficients: np.ndarray, samples: int = SAMPLES) -> SampledMesh:
    """Triangles of a whole surface."""
    x = np.linspace(0.0, 1.0, samples)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    cells = grid_cells(surface.n_elements, samples)
    return SampledMesh.of(surface.sample(xi, eta), cells, coefficients)


def crumple(
    surface: Pillow,
    coefficients: np.ndarray,
    held: np.ndarray,
    *,
    amplitude: float,
    seed: int = 0,
    distance: float | None = None,
) -> np.ndarray:
    """Crumpled coefficients of a closed bag.

    Parameters
    ----------
    surface : Pillow
    coefficients : (n_coefficients, 3) array
        A bag without contact.
    held : (n,) int array
        Elements that do not move (the inlet).
    amplitude : float
        Displacement a round over the bag's size.
    distance : float, optional
        Smallest distance kept between triangles; default a quarter of the shortest edge, below
        which neighbours in one sheet would count as contact.

    Raises
    ------
    CrumpleError
        A bag that already touches itself.
    """
    rng = np.random.default_rng(seed)
    mesh = sampled(surface, coefficients)
    size = float(np.ptp(coefficients, axis=0).max())
    if distance is None:
        distance = 0.25 * mesh.shortest_edge(coefficients)
    mask = _away_from(surface, coefficients, held)
    c = coefficients
    for _ in range(ROUNDS):
        d = mask * _displacement(rng, c, size, amplitude)
        d = _smooth(surface, d)
        free = mesh.free_step(c, c + d, distance)
        if free == 0.0:
            raise CrumpleError(
                f"its triangles are already closer than {distance:.2g} to each other and cannot "
                "move; thin or refine the bag"
            )
        c = c + SHARE * free * d
    return c


def _displacement(
    rng: np.random.Generator, c: np.ndarray, size: float, amplitude: float
) -> np.ndarray:
    """Random Fourier displacement of wave lengths 1/3 to 1 and a contraction of 0.15 of it."""
    centre = c.mean(axis=0)
    waves = rng.standard_normal((WAVES, 3))
    waves *= (2.0 * np.pi * rng.uniform(1.0, 3.0, WAVES) / np.linalg.norm(waves, axis=1))[:, None]
    phase = rng.uniform(0.0, 2.0 * np.pi, WAVES)
    field = np.cos((c - centre) @ waves.T / size + phase) @ rng.standard_normal((WAVES, 3))
    field *= amplitude * size / np.sqrt(np.mean(np.sum(field**2, axis=1)))
    return field - 0.15 * amplitude * (c - centre)


def _away_from(surface: Pillow, c: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Factor ``(n, 1)``: 0 on held elements and next to them, 1 further than their size away."""
    rows = np.unique(surface.element_dofs[held])
    centre = c[rows].mean(axis=0)
    radius = np.linalg.norm(c[rows] - centre, axis=1).max()
    x = np.clip((np.linalg.norm(c - centre, axis=1) / radius - 1.05) / 1.5, 0.0, 1.0)
    return (x * x * (3.0 - 2.0 * x))[:, None]


def _smooth(surface: Pillow, d: np.ndarray) -> np.ndarray:
    """Nearest field that is smooth at the corners."""
    R = surface.reduction
    return R @ splu((R.T @ R).tocsc()).solve(R.T @ d)
