"""Where a spline surface is only continuous: knot lines that a shell bends about for free.

A knot of multiplicity m leaves C^(p - m). The bending energy lives inside elements: across a C0
line it sees no kink, and the line is a hinge. Degree 1 is C0 at every knot and has no curvature.
"""

from __future__ import annotations

import numpy as np

from .surface import Surface
from .tensor_surface import TensorSurface


def check_smooth(surface: Surface, seams: bool = False) -> None:
    """Refuse a surface that is not C1 between its elements.

    Parameters
    ----------
    surface : Surface
        Of splines only knots between two of its elements count: an edge may have any multiplicity.
    seams : bool
        Accept C0 knot lines.

    Raises
    ------
    ValueError
        Degree 1, or a C0 knot line; naming the knot, its direction and the remedies. Triangles,
        unless seams are meant: they are only continuous.
    """
    triangles = surface.shape == "triangle"
    what, line = ("triangles", "edge") if triangles else ("splines", "knot")
    if surface.degree < 2:
        raise ValueError(
            f"{what} of degree 1 have no curvature, and every {line} would be a hinge: a shell "
            "with bending needs degree 2 or more (3 locks least), a membrane flexural_rigidity = 0"
        )
    if seams:
        return
    if not isinstance(surface, TensorSurface):
        raise ValueError(
            "triangles are only continuous, and a shell would bend about every edge as about a "
            "hinge: take shells.TriangleShell, which ties slopes across edges, or say seams=True "
            "where hinges are meant"
        )
    inside = np.zeros(surface.s.n_elements * surface.t.n_elements, dtype=bool)
    inside[surface.selected] = True
    table = inside.reshape(surface.s.n_elements, surface.t.n_elements)
    for direction, space, grid in (("s", surface.s, table), ("t", surface.t, table.T)):
        joins: np.ndarray = np.any(np.roll(grid, 1, axis=0) & grid, axis=1)  # i to i - 1
        joins[0] &= space.periodic
        bad = np.flatnonzero(joins & (space.multiplicity[:-1] >= space.degree))
        if bad.size:
            knot, m = space.breaks[bad[0]], space.multiplicity[bad[0]]
            more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
            raise ValueError(
                f"the surface is only C0 at the knot {direction} = {knot:.12g}{more}, of "
                f"multiplicity {m} at degree {space.degree}: a shell would bend about it as about "
                f"a hinge; give it multiplicity {space.degree - 1} or less or raise the degree, or "
                "say seams=True where two sheets are sewn together and turn freely"
            )
