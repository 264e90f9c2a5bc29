"""The channel with a square cavity of [T fig. 7.2]: [0, 3] x [0, 1] and [1, 2] x [-1, 0].

Inflow ``4 y (1 - y)`` on the left, no traction on the right, no slip elsewhere. The goal region is
the corner [1.9, 2] x [-1, -0.9]: sizes and place follow from matching the printed figures.
"""

from __future__ import annotations

import numpy as np
from skfem import Mesh, MeshQuad

LENGTH, HEIGHT = 3.0, 1.0
CAVITY = (1.0, 2.0, -1.0)  # left, right, bottom


def channel_cavity(cells: int, triangles: bool = False) -> Mesh:
    """Uniform mesh with named boundaries ``inlet``, ``outlet``, ``walls``.

    Parameters
    ----------
    cells : int
        Elements on a unit length.
    triangles : bool
        Cut each square in two.
    """
    x = np.linspace(0.0, LENGTH, int(LENGTH) * cells + 1)
    y = np.linspace(CAVITY[2], HEIGHT, 2 * cells + 1)
    mesh = MeshQuad.init_tensor(x, y)
    cx, cy = mesh.p[:, mesh.t].mean(axis=1)
    outside = (cy < 0.0) & ((cx < CAVITY[0]) | (cx > CAVITY[1]))
    mesh = mesh.remove_elements(np.flatnonzero(outside))
    if triangles:
        mesh = mesh.to_meshtri()
    return with_names(mesh)


def with_names(mesh: Mesh) -> Mesh:
    """The mesh with its boundaries named by position."""
    x, _ = mesh.p[:, mesh.facets].mean(axis=1)
    boundary = mesh.boundary_facets()
    inlet, outlet = x[boundary] < 1e-9, x[boundary] > LENGTH - 1e-9
    return mesh.with_boundaries(
        {
            "inlet": boundary[inlet],
            "outlet": boundary[outlet],
            "walls": boundary[~inlet & ~outlet],
        }
    )


def inflow(x: np.ndarray) -> np.ndarray:
    """Parabola of unit height."""
    return np.stack([4.0 * x[1] * (1.0 - x[1]), 0.0 * x[1]])


def rest(x: np.ndarray) -> np.ndarray:
    """No slip."""
    return np.zeros_like(x)
