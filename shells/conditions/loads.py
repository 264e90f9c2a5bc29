"""Loads on a shell: point loads, line loads and moments on edges, a pressure that follows.

Dead loads are arrays ``(n_coefficients, 3)``; loads that follow the configuration are callables
``load(c) -> (force, derivative)``. `ShellStructure.static` takes both. Area loads are ordinary
scikit-fem linear forms: ``LinearForm(lambda v, w: q * v[2]).assemble(basis)``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ..energy.volume import EnclosedVolume
from ..surfaces.element_basis import ElementBasis
from ..surfaces.spline_surface import SplineSurface
from .edge import edge

# A load that follows the configuration: (n_full, 3) to force and its sparse derivative.
Follower = Callable[[np.ndarray], tuple[np.ndarray, csr_matrix]]


def point_load(surface: SplineSurface, s: float, t: float, force: ArrayLike) -> np.ndarray:
    """Dead load of a force at one point.

    Parameters
    ----------
    surface : SplineSurface
    s, t : float
        Parameters of the point.
    force : (3,) array

    Returns
    -------
    (n_coefficients, 3) array

    Raises
    ------
    ValueError
        A point outside the surface: the load acts on no element.
    """
    for name, x, space in (("s", s, surface.s), ("t", t, surface.t)):
        if not space.breaks[0] <= x <= space.breaks[-1]:
            raise ValueError(
                f"point load at {name} = {x:g} acts on no element: {name} runs from "
                f"{space.breaks[0]:g} to {space.breaks[-1]:g}"
            )
    place = [
        min(int(np.searchsorted(space.breaks, x, side="right")) - 1, space.n_elements - 1)
        for x, space in ((s, surface.s), (t, surface.t))
    ]
    element = np.flatnonzero(surface.selected == place[0] * surface.t.n_elements + place[1])
    if not element.size:
        raise ValueError(f"point load at ({s:g}, {t:g}) acts on no element of this restriction")
    xi, eta = (
        np.array([(x - space.breaks[e]) / (space.breaks[e + 1] - space.breaks[e])])
        for x, space, e in ((s, surface.s, place[0]), (t, surface.t, place[1]))
    )
    row = surface.sample(xi, eta)[element[0]].toarray().ravel()
    return row[:, None] * np.asarray(force, dtype=float)


def line_load(
    surface: SplineSurface, direction: str, end: int, force: ArrayLike, reference: np.ndarray
) -> np.ndarray:
    """Dead load of a force per reference length along an edge.

    Parameters
    ----------
    surface : SplineSurface
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
        Start or end of that direction.
    force : (3,) array
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.

    Returns
    -------
    (n_coefficients, 3) array

    Raises
    ------
    ValueError
        An edge that no element of the surface has.
    """
    return edge(surface, direction, end, reference).line_load(force)


def end_moment(
    surface: SplineSurface, direction: str, end: int, size: float, reference: np.ndarray
) -> Follower:
    """Moment per reference length about an edge, turning with it.

    Parameters
    ----------
    surface : SplineSurface
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
        Start or end of that direction.
    size : float
        Positive moments turn the outward direction across the edge towards the normal.
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.

    Returns
    -------
    callable
        ``load(c)`` returns the force ``(n_coefficients, 3)`` on a configuration and its
        derivative, a sparse matrix (see `shells.conditions.edge.Edge.moment`).

    Raises
    ------
    ValueError
        An edge that no element of the surface has.
    """
    rim = edge(surface, direction, end, reference)
    return lambda c: rim.moment(c, size)


def follower_pressure(basis: ElementBasis, size: float) -> Follower:
    """Pressure along the current normal, on any surface, open or closed.

    Its virtual work is ``p int rho . (theta_s x theta_t)``; where open edges move the derivative
    is not symmetric.

    Parameters
    ----------
    basis : ElementBasis
        Vector basis of the surface under pressure.
    size : float
        The pressure p.

    Returns
    -------
    callable
        ``load(c)`` returns the force ``(n_coefficients, 3)`` on a configuration and its
        derivative, a sparse matrix.
    """
    volume = EnclosedVolume(basis)

    def load(c: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        force, slope = volume.pressure_force(c.ravel()[: basis.N])
        return size * force.reshape(-1, 3), size * slope

    return load
