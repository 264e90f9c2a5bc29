"""Is a surface closed, are its normals outward, and how many bodies is it?

Elements meet edge to edge: every edge coincides with exactly one other, run through in the
opposite direction, or is contracted to a point. Works on positions, so that wraps, poles and
unions of surfaces need no special treatment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .bernstein import bernstein
from .configuration import centred_control, shortest_edge
from .patches import SurfacePatches
from .surface_points import point_set

MATCH = 1e-6  # edges closer than this fraction of their length are one


class SurfaceError(ValueError):
    """A surface on which the boundary integrals make no sense, with the remedy."""


@dataclass(frozen=True)
class Edges:
    """Edges of all elements, in the sense of ``x_s x x_t``.

    Attributes
    ----------
    points : (n, 3, 3) array
        Start, middle and end.
    lengths : (n,) array
    elements : (n,) int array
    """

    points: np.ndarray
    lengths: np.ndarray
    elements: np.ndarray

    @classmethod
    def of(cls, control: np.ndarray, origin: np.ndarray) -> Edges:
        """Edges of Bezier patches ``(n_elements, p + 1, p + 1, 3)``, contracted ones left out.

        ``control`` counts from ``origin``, see `hbem.surfaces.configuration.centred_control`.
        """
        sides = np.stack(
            [control[:, :, 0], control[:, -1], control[:, ::-1, -1], control[:, 0, ::-1]], axis=1
        )
        n, _, m, _ = sides.shape
        table = bernstein(m - 1, np.array([0.0, 0.5, 1.0]))
        points = np.einsum("qk,ejkc->ejqc", table, sides).reshape(4 * n, 3, 3)
        lengths = np.linalg.norm(np.diff(sides, axis=2), axis=-1).sum(axis=-1)
        kept = (
            lengths > shortest_edge(lengths.max(axis=1, keepdims=True), control, origin)
        ).ravel()
        lengths = lengths.ravel()
        return cls(points[kept], lengths[kept], np.repeat(np.arange(n), 4)[kept])


def partners(edges: Edges) -> tuple[np.ndarray, np.ndarray]:
    """The edge that coincides with each (-1: none) and whether both run the same way."""
    tree = cKDTree(edges.points[:, 1])
    k = min(6, edges.lengths.size)
    _, near = tree.query(edges.points[:, 1], k=k)
    me = np.arange(edges.lengths.size)[:, None]
    allowed = (MATCH * edges.lengths)[:, None]

    def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.linalg.norm(a - b, axis=-1)

    ends, others = edges.points[:, None], edges.points[near]
    middle = apart(ends[:, :, 1], others[:, :, 1]) <= allowed
    reverse = np.maximum(
        apart(ends[:, :, 0], others[:, :, 2]), apart(ends[:, :, 2], others[:, :, 0])
    )
    along = np.maximum(apart(ends[:, :, 0], others[:, :, 0]), apart(ends[:, :, 2], others[:, :, 2]))
    match = (near != me) & middle & (np.minimum(reverse, along) <= allowed)
    # a ring closed by one edge coincides with itself both ways: reverse wins
    first = match.argmax(axis=1)
    found = np.where(match.any(axis=1), np.take_along_axis(near, first[:, None], 1)[:, 0], -1)
    same = np.take_along_axis(along < reverse, first[:, None], 1)[:, 0] & (found >= 0)
    return found, same


def closed_components(patches: SurfacePatches, coefficients: np.ndarray) -> np.ndarray:
    """Closed component of each density function.

    Parameters
    ----------
    patches : SurfacePatches
    coefficients : (n_coefficients, 3) array

    Returns
    -------
    (n_dofs,) int array

    Raises
    ------
    SurfaceError
        An open surface, elements given twice, elements of opposite orientation side by side, or
        inward normals.
    ValueError
        Coefficients of a wrong shape, not finite, or beyond the reach of double precision.
    """
    control, origin = centred_control(patches, coefficients)
    n = patches.n_elements
    edges = Edges.of(control, origin)
    _refuse_twice(control)
    partner, same = partners(edges)
    _refuse_open(edges, partner, origin)
    if same.any():
        e = edges.elements[same.argmax()]
        raise SurfaceError(
            f"{np.count_nonzero(same)} edges join elements of opposite orientation (first: element "
            f"{e}); let s and t run so that x_s x x_t points outwards everywhere"
        )
    links = (np.ones(partner.size), (edges.elements, edges.elements[partner]))
    _, label = connected_components(coo_matrix(links, shape=(n, n)), directed=False)
    volumes = signed_volumes(control, label)
    if np.any(volumes <= 0.0):
        raise SurfaceError(
            f"component {int(volumes.argmin())} encloses the volume {volumes.min():.3g}: its "
            "normals point inwards; reverse s or t of its elements"
        )
    owner = np.repeat(np.arange(n), np.diff(patches.indptr))
    result = np.full(patches.n_dofs, -1)
    result[patches.dofs] = label[owner]
    return result


def _refuse_twice(control: np.ndarray) -> None:
    """Elements whose corners and middles coincide, however their axes run."""
    corners = control[:, [0, 0, -1, -1], [0, -1, 0, -1]]
    degree = control.shape[1] - 1
    half = bernstein(degree, np.array([0.5]))[0]
    middles = np.einsum("i,eijc,j->ec", half, control, half)
    size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    pairs = cKDTree(middles).query_pairs(MATCH * size.max(), output_type="ndarray")
    if pairs.size == 0:
        return
    first, second = corners[pairs[:, 0]], corners[pairs[:, 1]]
    away = np.linalg.norm(first[:, :, None] - second[:, None], axis=-1)
    away = np.maximum(away.min(axis=1), away.min(axis=2)).max(axis=1)
    middle = np.linalg.norm(np.subtract(*middles[pairs.T]), axis=1)
    twice = np.maximum(away, middle) <= MATCH * np.maximum(size[pairs].min(axis=1), 1e-300)
    if twice.any():
        e, f = min(sorted(pair) for pair in pairs[twice].tolist())
        raise SurfaceError(
            f"{np.count_nonzero(twice)} elements are given twice: element {f} duplicates element "
            f"{e}; leave one of them out"
        )


def _refuse_open(edges: Edges, partner: np.ndarray, origin: np.ndarray) -> None:
    loose = partner < 0
    if loose.any():
        first = int(loose.argmax())
        x = ", ".join(f"{c:.4g}" for c in edges.points[first, 1] + origin)
        raise SurfaceError(
            f"the surface is open: {np.count_nonzero(loose)} edges meet no other (first: an edge "
            f"of element {edges.elements[first]} at {x}); close it, edge to edge, with a cap or "
            "an inlet"
        )


def signed_volumes(control: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Volume enclosed by each component, negative for inward normals [T 2.27]."""
    points = point_set(control, control.shape[1] + 1)
    local = points.offsets.reshape(label.size, -1, 3)
    weights = (points.weights[:, None] * points.normals).reshape(local.shape)
    volumes = np.zeros(label.max() + 1)
    for k in range(volumes.size):
        inside = label == k
        centre = local[inside].reshape(-1, 3).mean(axis=0)
        volumes[k] = np.sum((local[inside] - centre) * weights[inside]) / 3.0
    return volumes
