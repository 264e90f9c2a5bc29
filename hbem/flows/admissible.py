"""What a flow problem must fulfil before anything is solved: one clear refusal for each fault."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import ArrayLike

from ..near.crossing import arrangement
from ..surfaces.configuration import real_array, rounding
from ..surfaces.surface_points import SampledSurface
from ..surfaces.topology import SurfaceError

logger = logging.getLogger(__name__)
ROUNDED = 100.0  # traction error over rounding of coordinates in units of the gap: measured 60


def check_viscosities(viscosity: float, ratio: float, *, background: bool) -> None:
    """Refuse viscosities that are no numbers, and a background without outer fluid.

    Parameters
    ----------
    viscosity, ratio : float
        Of the fluid inside; outer over inner.
    background : bool
        Whether there is an undisturbed flow of the outer fluid.

    Raises
    ------
    ValueError
    """
    for name, value in (("viscosity", viscosity), ("viscosity_ratio", ratio)):
        if np.iscomplexobj(value) or not np.isfinite(value):
            raise ValueError(f"{name} must be a finite real number, got {value}")
    if not viscosity > 0.0:
        raise ValueError(f"viscosity must be positive, got {viscosity:g}")
    if ratio < 0.0:
        raise ValueError(
            f"viscosity_ratio must be finite and not negative, got {ratio:g}; it is outer over "
            "inner viscosity"
        )
    if background and ratio == 0.0:
        raise ValueError(
            "viscosity_ratio = 0 has no outer fluid that a background could move: leave the "
            "background out, or give a positive ratio"
        )


def velocities(name: str, values: ArrayLike, points: np.ndarray) -> np.ndarray:
    """Velocities at points ``(n, 3)``; one of three numbers serves all.

    Raises
    ------
    ValueError
        Complex or infinite values, or a wrong shape.
    """
    u = real_array(name, values)
    if u.shape == (3,):
        u = np.broadcast_to(u, points.shape)
    if u.shape != points.shape:
        raise ValueError(f"{name}: expected finite velocities {points.shape}, got {u.shape}")
    return u


def check_gap(surface: SampledSurface, gap: float, tolerance: float) -> None:
    """Refuse gaps so narrow that rounding of coordinates alone costs more than the tolerance.

    Parameters
    ----------
    surface : SampledSurface
    gap : float
        The narrowest.
    tolerance : float
        Relative traction error asked for.

    Raises
    ------
    ValueError
    """
    rounded = rounding(surface.control, surface.origin)
    if ROUNDED * rounded > tolerance * gap:
        raise ValueError(
            f"coordinates are rounded to {rounded:.1g} in a gap of {gap:.3g}: a traction error of "
            f"{tolerance:g} is beyond double precision's reach; move the surface towards the "
            "origin of coordinates, open the gap, or allow a larger error"
        )


def check_bodies(surface: SampledSurface, components: np.ndarray, ratio: float) -> None:
    """Refuse bodies that cross, and nested ones of which the formulation knows nothing.

    Inside n bodies the formulation has the viscosity ``lambda + (1 - lambda) n``, with 1 that
    inside a single one; it must be positive.

    Parameters
    ----------
    surface : SampledSurface
    components : (n_dofs,) int array
        Closed component of each density function.
    ratio : float
        Viscosity ratio ``lambda``.

    Raises
    ------
    SurfaceError
    """
    p = surface.patches
    if components.max() == 0:
        return
    found = arrangement(surface, components[p.dofs[p.indptr[:-1]]])
    if found.tested == 0:
        logger.info("%d bodies in boxes apart: crossing not tested", components.max() + 1)
    if found.crossing is not None:
        a, b, x = found.crossing
        at = ", ".join(f"{c:.4g}" for c in x)
        raise SurfaceError(
            f"bodies {a} and {b} cross or touch at {at}: move them apart, or join them to one "
            "surface"
        )
    k = int(found.depth.argmax())
    core = ratio + (1.0 - ratio) * (found.depth[k] + 1)
    if found.depth[k] == 0 or ratio == 1.0:
        return
    outside = int(found.inside[k].argmax())
    if core <= 0.0:
        raise SurfaceError(
            f"body {k} lies inside body {outside}: with viscosity_ratio = {ratio:g} the viscosity "
            f"inside it would be {core:g} times that around it; nested bodies need a ratio below "
            f"{1.0 + 1.0 / found.depth[k]:g}, or a flow of their own"
        )
    logger.warning(
        "body %d lies inside body %d: the fluid inside it has %g times the viscosity of that "
        "around it",
        k,
        outside,
        core,
    )
