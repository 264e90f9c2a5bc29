"""Loads on a shell: point loads, line loads and moments on edges, a pressure that follows.

Dead loads are arrays ``(n_coefficients, 3)``; loads that follow the configuration are callables
``load(c) -> (force, derivative)``. `ShellStructure.static` takes both. Area loads are ordinary
scikit-fem linear forms: ``LinearForm(lambda v, w: q * v[2]).assemble(basis)``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_matrix

from ..energy.volume import EnclosedVolume
from ..surfaces.surface_basis import SurfaceBasis
from .edge import edge

Follower = Callable[[np.ndarray], tuple[np.ndarray, csr_matrix]]


def point_load(surface: object, s: float, t: float, force: np.ndarray) -> np.ndarray:
    """Dead load of a force ``(3,)`` at parameters (s, t).

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
    if place[0] * surface.t.n_elements + place[1] not in surface.selected:
        raise ValueError(f"point load at ({s:g}, {t:g}) acts on no element of this restriction")
    row = np.outer(surface.s.evaluate(s)[0], surface.t.evaluate(t)[0]).ravel()
    return row[surface.kept][:, None] * np.asarray(force, dtype=float)


def line_load(
    surface: object, direction: str, end: int, force: np.ndarray, reference: np.ndarray
) -> np.ndarray:
    """Dead load ``(n_coefficients, 3)`` of a force per reference length along an edge.

    Parameters
    ----------
    direction : {"s", "t"}
        Parameter that is constant along the edge.
    end : {0, 1}
    force : (3,) array
    reference : (n_coefficients, 3) array
        Configuration in which lengths are measured.
    """
    return edge(surface, direction, end, reference).line_load(force)


def end_moment(
    surface: object, direction: str, end: int, size: float, reference: np.ndarray
) -> Follower:
    """Moment per reference length about an edge, turning with it (see `edge.Edge.moment`)."""
    rim = edge(surface, direction, end, reference)
    return lambda c: rim.moment(c, size)


def follower_pressure(basis: SurfaceBasis, size: float) -> Follower:
    """Pressure along the current normal, on any surface, open or closed.

    Its virtual work is ``p int rho . (theta_s x theta_t)``; where open edges move the derivative
    is not symmetric.
    """
    volume = EnclosedVolume(basis)
    gradient, hessian = volume.short_forms

    def load(c: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        x = c.ravel()[: basis.N]
        force = size * gradient.assemble(basis, x=x).reshape(-1, 3)
        return force, size * hessian.assemble(basis, x=x)

    return load
