"""One configuration of a surface: control points about an origin, within double precision's reach.

Positions far from the origin of coordinates leave only rounding to their differences, on which all
integrals depend: control points are centred first, and refused where rounding has the size of what
they describe.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .patches import SurfacePatches
from .triangles import quadrilaterals

COLLAPSED = 1e-7  # an edge shorter than this many ball radii is a pole
NOISE = 64.0  # an edge shorter than this many roundings of a coordinate is one too
# Roundings that the shortest edge must have at least: of the coordinates of the origin, which move
# control points only, and of positions relative to it, whose differences are the integrals' (errors
# of a force at the limits: 1e-6 of a gap's, 1e-5).
FAR, RESOLVED = 1e5, 1e7
REACH = 1e-50, 1e50  # extents whose fifth powers, and those of all distances, are numbers


def centred_control(
    patches: SurfacePatches, coefficients: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Control points ``(n_elements, degree + 1, degree + 1, 3)`` relative to an origin ``(3,)``.

    The origin is that of the coordinates where it lies within one extent of the surface, else the
    surface's middle: positions far away would leave only rounding to their differences.

    Raises
    ------
    ValueError
        Coefficients of a wrong shape, not finite, or beyond the reach of double precision.
    """
    control = control_points(patches, coefficients)
    flat = control.reshape(-1, 3)
    low, high = flat.min(axis=0), flat.max(axis=0)
    extent, middle = float(np.max(high - low)), 0.5 * (low + high)
    if extent > 0.0 and not REACH[0] <= extent <= REACH[1]:
        raise ValueError(
            f"the surface measures {extent:.3g}: beyond double precision's reach ({REACH[0]:g} to "
            f"{REACH[1]:g}); choose another unit of length"
        )
    origin = middle if np.abs(middle).max() > extent else np.zeros(3)
    control = control - origin
    lengths = edge_lengths(control)
    real = lengths[lengths > shortest_edge(lengths.max(axis=1, keepdims=True), control, origin)]
    epsilon, shortest = np.finfo(float).eps, float(real.min(initial=np.inf))
    least = epsilon * (FAR * np.abs(origin).max() + RESOLVED * np.abs(control).max(initial=0.0))
    if shortest < least:
        raise ValueError(
            f"an element's edge of length {shortest:.3g} where coordinates are rounded to "
            f"{rounding(control, origin):.1g}: beyond double precision's reach (edges of "
            f"{least:.2g}); move the surface towards the origin of coordinates, bring bodies "
            "closer to each other, or make elements larger"
        )
    return control, origin


def rounding(control: np.ndarray, origin: np.ndarray) -> float:
    """To what the coordinates of control points relative to an origin are rounded."""
    return float(np.finfo(float).eps * (np.abs(origin).max() + np.abs(control).max(initial=0.0)))


def edge_lengths(control: np.ndarray) -> np.ndarray:
    """Lengths of the control polygons of the four edges of every patch, ``(n_elements, 4)``."""
    edges = np.stack([control[:, 0], control[:, -1], control[:, :, 0], control[:, :, -1]], axis=1)
    return np.linalg.norm(np.diff(edges, axis=2), axis=-1).sum(axis=-1)


def shortest_edge(size: np.ndarray, control: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Lengths below which an edge of elements of these sizes is contracted to a point."""
    return np.maximum(COLLAPSED * size, NOISE * rounding(control, origin))


def control_points(patches: SurfacePatches, coefficients: np.ndarray) -> np.ndarray:
    """Bezier control points ``(n_elements, degree + 1, degree + 1, 3)`` of a configuration.

    Raises
    ------
    ValueError
        Coefficients of a wrong shape or not finite.
    """
    coefficients = real_array("coefficients", coefficients)
    if patches.shape == "triangle":
        patches = quadrilaterals(patches)
    if coefficients.shape != (patches.n_coefficients, 3):
        raise ValueError(
            f"expected coefficients ({patches.n_coefficients}, 3), got {coefficients.shape}"
        )
    n = patches.geometry_degree + 1
    return np.ascontiguousarray((patches.bezier @ coefficients).reshape(-1, n, n, 3))


def real_array(name: str, values: ArrayLike) -> np.ndarray:
    """Values as floating-point numbers.

    Raises
    ------
    ValueError
        Complex, infinite or undefined values.
    """
    values = np.asarray(values)
    if np.iscomplexobj(values):
        raise ValueError(f"{name}: complex values; give real ones (real and imaginary part apart)")
    values = np.asarray(values, dtype=float)
    bad = np.argwhere(~np.isfinite(values))
    if bad.size:
        at = tuple(bad[0].tolist())
        raise ValueError(f"{name} are not finite: {values[at]} at {at}")
    return values
