"""A mesh in other units, or in another place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..folding import Map
from .facet_mesh import FacetMesh

UNITS = {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}


def scaled(facets: FacetMesh, factor: float) -> FacetMesh:
    """All lengths times a factor."""
    return facets if factor == 1.0 else moved(facets, lambda points: factor * points)


def moved(facets: FacetMesh, by: Map) -> FacetMesh:
    """Points, middles and unfolded places moved by a map that keeps lines straight."""

    def at(points: np.ndarray | None) -> np.ndarray | None:
        return None if points is None else by(points.reshape(-1, 3)).reshape(points.shape)

    return replace(
        facets,
        points=by(facets.points),
        middles=at(facets.middles),
        reference=at(facets.reference),
    )
