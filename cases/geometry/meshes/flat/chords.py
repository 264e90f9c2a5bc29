"""Chords of a flat bag: edges across a sheet that join two points of its seam.

Sheets share the points of the seam, so a chord of both sheets would be an edge of four
triangles; and a sheet lifted off the other stays down on it along a chord. Chords are bisected,
in each sheet by a point of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import FacetMesh
from ..flat_triangles import sides_of
from ..mending.bisection import bisected
from .sheets import told_apart


def split_chords(facets: FacetMesh) -> FacetMesh:
    """Bisect the edges that join two points of the seam and are no seam.

    Parameters
    ----------
    facets : FacetMesh
        Flat, of no thickness; sheets share the points of their seam. Orientation does not matter.

    Returns
    -------
    FacetMesh
        The same mesh where it has no chords.

    Raises
    ------
    MeshError
        A mesh that is not flat, or sheets that cannot be told apart.
    """
    sheets = told_apart(facets)
    rim = np.concatenate([sheets.seam, sheets.open_edges])
    on_rim = np.zeros(facets.points.shape[0], dtype=bool)
    on_rim[rim] = True
    ends = np.sort(sides_of(facets.triangles), axis=2)
    chords = on_rim[ends].all(axis=2)
    known = {(int(a), int(b)) for a, b in rim}
    for t, k in np.argwhere(chords):
        chords[t, k] = (int(ends[t, k, 0]), int(ends[t, k, 1])) not in known
    if not chords.any():
        return facets
    split, _ = bisected(facets, chords, sheets.upper.astype(np.int64))
    count = split.points.shape[0] - facets.points.shape[0]
    note = f"{count} edges across a sheet that joined two points of its seam bisected"
    return replace(split, notes=(*facets.notes, note))
