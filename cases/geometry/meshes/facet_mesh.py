"""A triangulation as a file gives it, or as repairs leave it: what all steps to a bag pass on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


class MeshError(ValueError):
    """A mesh that cannot be used: what, where, and the remedy, in one line."""


def place(point: np.ndarray) -> str:
    """A point in words, rounding errors as zeros."""
    point = np.where(np.abs(point) > 1e-12 * np.abs(point).max(initial=0.0), point, 0.0)
    return f"({', '.join(f'{x:.4g}' for x in point)})"


@dataclass(frozen=True)
class FacetMesh:
    """Triangles with groups; counterclockwise seen from outside, once they are oriented.

    Attributes
    ----------
    points : (n, 3) array
    triangles : (m, 3) int array
    groups : mapping of str to (k,) int array
        Triangles of each named group, part or solid, increasing; a triangle may be in several.
    middles : (m, 3, 3) array, optional
        Points on the edges 01, 12 and 20 of second-order triangles.
    reference : (n, 3) array, optional
        Places of the points in the unfolded, stress-free bag.
    notes : tuple of str
        What was read, repaired and left out, one line each.
    """

    points: np.ndarray
    triangles: np.ndarray
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)
    middles: np.ndarray | None = None
    reference: np.ndarray | None = None
    notes: tuple[str, ...] = ()
