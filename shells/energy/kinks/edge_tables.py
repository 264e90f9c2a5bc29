"""What the kernel of kinks takes: functions, frames and weights of one batch of edges.

A batch has either two triangles at each edge, or one and a fixed conormal beyond (`HeldSlopes`):
a clamp or a plane of symmetry. The energy of an edge,

    int ( -M theta + eta D theta^2 / (2 h) ) ds,    M = D sum_i A_i / A (kappa_nn + nu kappa_tt)_i,

with ``h = A / |e|`` and A the area of its triangles. Weighted by areas, ``eta > 3 p (p - 1) / 2``
(3 at degree 2, 9 at degree 3) leaves no mode of negative energy on flat triangles of any shape, by
``int_e f^2 <= p (p - 1) / 2 |e| / A int_T f^2`` for polynomials f of degree p - 2 (Warburton and
Hesthaven 2003) and a third of a triangle's energy for each edge. Equal weights would need more, the
more neighbours differ in size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...surfaces.splines import unit_gauss
from ...surfaces.triangles.triangle_surface import TriangleSurface
from ..material import Material
from ..points.jet_sums import JetSums
from .edge_geometry import Frame, Side, angle, conormals, frame, sides_of, tangents


@dataclass(frozen=True)
class HeldSlopes:
    """Rim edges whose slope is held: the conormal out of the surface stays as given.

    The trace is held by the extraction, or in a plane of symmetry kept in that plane.

    Attributes
    ----------
    edges : (n,) int array
        Numbers of rim edges.
    conormals : (3,) or (n, 3) array, optional
        Directions beyond the edges: the normal of a plane of symmetry (out of the body), or how a
        neighbour goes on; default those of ``at``, without a kink that is free of stress.
    at : (n_coefficients, 3) array, optional
        Where the slopes are as they are held; default the reference. For a shell whose reference
        lies elsewhere, unfolded.
    """

    edges: np.ndarray
    conormals: np.ndarray | None = None
    at: np.ndarray | None = None


@dataclass(frozen=True)
class EdgeTables:
    """One batch, points of its edges as `_kink_kernels` takes them.

    Attributes
    ----------
    edges : (n,) int array
        Numbers of the edges.
    sums : JetSums
        Functions' parts of the five vectors.
    fixed : (n, n_points, 3) array or None
        g2 of edges with one triangle.
    weights : (n, n_points) array
        With the share of soft edges.
    free : (n, n_points, 3) array
        Cosine and sine of the stress-free kink, and moment of the stress-free shell.
    moduli : (n, n_points, 2) array
        D by the triangles' shares of their area.
    stiffness : (n, n_points) array
        ``eta D / h``.
    """

    edges: np.ndarray
    sums: JetSums
    fixed: np.ndarray | None
    weights: np.ndarray
    free: np.ndarray
    moduli: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True)
class Rest:
    """The stress-free shell: metric and frames of `reference`, curvature of `curved`.

    Attributes
    ----------
    reference, curved : (n_coefficients, 3) array
    kinks : (n_edges, n_points) array or None
        Those of ``curved`` where None.
    areas : (n_elements,) array
        Of the reference.
    """

    reference: np.ndarray
    curved: np.ndarray
    kinks: np.ndarray | None
    areas: np.ndarray


def edge_tables(
    surface: TriangleSurface,
    edges: np.ndarray,
    rest: Rest,
    material: Material,
    eta: float,
    share: np.ndarray,
    beyond: np.ndarray | None = None,
    *,
    level: bool = False,
) -> EdgeTables:
    """Tables of edges with two triangles, or of rim edges with fixed conormals ``beyond``.

    Parameters
    ----------
    share : (n_edges,) array
        Of ``D`` that acts at each edge of the batch.
    beyond : (n_edges, n_points, 3) array, optional
    level : bool
        The stress-free kink to ``beyond`` is none.
    """
    sides = sides_of(surface, edges)
    frames = [frame(side, rest.reference) for side in sides]
    D, own = material.stiffness * material.flexural_rigidity, surface.degree + 1
    further = [side.dofs[:, own:] for side in sides]
    rows = np.concatenate([sides[0].dofs[:, :own], *further], axis=1)
    table = np.zeros((*frames[0].speed.shape, 5, rows.shape[1]))
    for s, (side, at) in enumerate(zip(sides, frames, strict=True)):
        (t, g), m = at.first(side.first), _moment(at, side.second, material)
        table[..., 0, :own] = t[..., :own]
        columns = np.r_[:own, own + s * further[0].shape[1] + np.arange(further[0].shape[1])]
        table[..., 1 + s, columns], table[..., 3 + s, columns] = g, m
    w = unit_gauss(surface.degree + 1)[1]
    triangles = surface.graph.triangles[edges, : len(sides)]
    areas = rest.areas[triangles]
    moduli = np.zeros((edges.size, 2))
    moduli[:, : len(sides)] = D * areas / areas.sum(axis=1, keepdims=True)
    height = areas.sum(axis=1) / (frames[0].speed @ w)
    points = (*frames[0].speed.shape, 2)
    return EdgeTables(
        edges,
        JetSums(table, np.ascontiguousarray(rows)),
        beyond,
        frames[0].speed * w * share[:, None],
        _free(sides, frames, edges, rest, material, moduli, beyond, level),
        np.broadcast_to(moduli[:, None], points).copy(),
        np.broadcast_to((eta * D / height)[:, None], points[:2]).copy(),
    )


def _moment(at: Frame, second: np.ndarray, material: Material) -> np.ndarray:
    """``f_nn + nu f_tt`` of functions or, last but one axis, of a configuration."""
    tt, nn = at.second(second)
    return nn + material.poisson_ratio * tt


def _free(
    sides: list[Side],
    frames: list[Frame],
    edges: np.ndarray,
    rest: Rest,
    material: Material,
    moduli: np.ndarray,
    beyond: np.ndarray | None,
    level: bool,
) -> np.ndarray:
    """Cosine and sine of the stress-free kinks, and the moment M0 of the curvature B."""
    t = tangents(sides[0], rest.curved)
    g = [conormals(side, rest.curved) for side in sides]
    theta = np.zeros(t.shape[:2]) if level else angle(t, g[0], g[1] if beyond is None else beyond)
    if rest.kinks is not None:
        theta = rest.kinks[edges]
    moment = np.zeros(t.shape[:2])
    for side, at, conormal, modulus in zip(sides, frames, g, moduli.T, strict=False):
        second = side.along(rest.curved)[1]
        m = _moment(at, np.swapaxes(second, -1, -2), material)
        moment += modulus[:, None] * np.einsum("eqc,eqc->eq", m, np.cross(conormal, t))
    return np.stack([np.cos(theta), np.sin(theta), moment], axis=-1)
