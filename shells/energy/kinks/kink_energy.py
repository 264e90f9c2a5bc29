"""Energy of the kinks of a surface of triangles, in batches of edges, with both variations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..._threads_kernels import over
from ...surfaces.triangles.triangle_basis import TriangleBasis
from ..material import Material
from . import _kink_kernels as kernels
from .block_scatter import BlockScatter
from .edge_geometry import conormals, sides_of, tangents
from .edge_tables import EdgeTables, HeldSlopes, Rest, edge_tables

BLOCK = 256  # edges at a time: their matrices stay in the cache


@dataclass(frozen=True)
class KinkEnergy:
    """``sum over edges of int (-M theta + eta D theta^2 / (2 h)) ds``; see `TriangleShell`.

    Attributes
    ----------
    batches : sequence of EdgeTables
        Edges of two triangles, then those that are held; empty without flexural rigidity.
    """

    batches: Sequence[EdgeTables]

    @property
    def edges(self) -> np.ndarray:
        """Numbers of the edges, ``(n,)``."""
        return np.concatenate([np.empty(0, dtype=int), *(b.edges for b in self.batches)])

    @property
    def held(self) -> KinkEnergy:
        """The part that is held in space."""
        return KinkEnergy([b for b in self.batches if b.one_sided])

    @property
    def groups(self) -> list[np.ndarray]:
        """Coefficients of each edge, batch by batch."""
        return [b.dofs for b in self.batches]

    def energy(self, x: np.ndarray) -> float:
        """Their energy at coefficients ``x (n_coefficients, 3)``."""
        total = 0.0
        for b in self.batches:
            out = np.empty(b.edges.size)
            over(out.size, kernels.energy, *_arguments(b, x, out))
            total += float(out.sum())
        return total

    def forces(self, x: np.ndarray) -> list[np.ndarray]:
        """First variations of each batch, ``(n, 3 m)``."""
        found = []
        for b in self.batches:
            found.append(np.empty((b.edges.size, 3 * b.dofs.shape[1])))
            none = np.empty((1, 1, 1))
            over(b.edges.size, kernels.force_and_tangent, *_arguments(b, x, False, found[-1], none))
        return found

    def tangents(
        self, x: np.ndarray, blocks: BlockScatter, data: np.ndarray, first: int
    ) -> list[np.ndarray]:
        """First variations as `forces`; second ones added to data, of groups from ``first`` on."""
        found = []
        for group, b in enumerate(self.batches, first):
            n, m = b.dofs.shape
            R, K = np.empty((n, 3 * m)), np.empty((min(n, BLOCK), 3 * m, 3 * m))
            for start in range(0, n, BLOCK):
                part = slice(start, min(start + BLOCK, n))
                own = K[: part.stop - start]
                arguments = _arguments(b, x, True, R[part], own, part=part)
                over(len(own), kernels.force_and_tangent, *arguments)
                blocks.add(data, group, own, part)
            found.append(R)
        return found

    def changes(self, x: np.ndarray) -> list[np.ndarray]:
        """Kinks less the stress-free ones at the Gauss points of each batch."""
        found = []
        for b in self.batches:
            found.append(np.empty(b.weights.shape))
            over(b.edges.size, kernels.kinks, *_arguments(b, x, found[-1]))
        return found


def kink_energy(
    basis: TriangleBasis,
    material: Material,
    rest: Rest,
    eta: float,
    soft: np.ndarray | None,
    held: Sequence[HeldSlopes],
) -> KinkEnergy:
    """The energy of all edges with a share of the stiffness, and of those whose slope is held."""
    surface, batches = basis.surface, []
    pairs = surface.graph.triangles
    share = _shares(soft, len(pairs))
    inner = np.flatnonzero((pairs[:, 1] >= 0) & (share > 0.0))
    if inner.size:
        batches.append(edge_tables(surface, inner, rest, material, eta, share[inner]))
    for slopes in held:
        edges = np.asarray(slopes.edges, dtype=int)
        _check_rim(basis, edges)
        if edges.size:
            beyond = _beyond(basis, slopes, edges, rest)
            own = share[edges]
            level = slopes.conormals is None
            batches.append(
                edge_tables(surface, edges, rest, material, eta, own, beyond, level=level)
            )
    return KinkEnergy(batches)


def _arguments(
    b: EdgeTables, x: np.ndarray, *outputs: Any, part: slice = slice(None)
) -> tuple[Any, ...]:
    c = np.ascontiguousarray(np.asarray(x, dtype=float).reshape(-1, 3))
    cut = tuple(a[part] for a in _arrays(b))
    return (*cut, c, *outputs)


def _arrays(b: EdgeTables) -> tuple[np.ndarray, ...]:
    return b.dofs, b.trace, b.beside, b.fixed, b.weights, b.free, b.moduli, b.stiffness


def _shares(soft: np.ndarray | None, n: int) -> np.ndarray:
    share = np.ones(n) if soft is None else np.asarray(soft, dtype=float)
    if share.shape != (n,):
        raise ValueError(f"soft: expected a share for each of {n} edges, got {share.shape}")
    if not np.all((share >= 0.0) & (share <= 1.0)):
        raise ValueError("soft: shares of the bending stiffness must lie in [0, 1]")
    return share


def _check_rim(basis: TriangleBasis, edges: np.ndarray) -> None:
    graph = basis.surface.graph
    if (inner := graph.triangles[edges, 1] >= 0).any():
        a, b = graph.vertices[edges[inner][0]]
        raise ValueError(f"clamp: edge ({a}, {b}) has two triangles, so it is no rim edge")


def _beyond(basis: TriangleBasis, slopes: HeldSlopes, edges: np.ndarray, rest: Rest) -> np.ndarray:
    """Fixed conormals at the Gauss points, ``(n, n_points, 3)``."""
    (side,) = sides_of(basis.surface, edges)
    own = conormals(side, rest.reference if slopes.at is None else slopes.at)
    if slopes.conormals is None:
        return own
    given = np.asarray(slopes.conormals, dtype=float)
    if given.shape not in ((3,), (edges.size, 3)):
        raise ValueError(f"clamp: expected conormals (3,) or ({edges.size}, 3), got {given.shape}")
    given = np.broadcast_to(given[..., None, :], own.shape)
    across = np.linalg.norm(np.cross(given, tangents(side, rest.reference)), axis=-1)
    if (bad := across.min(axis=1) <= 1e-9).any():
        a, b = basis.surface.graph.vertices[edges[bad][0]]
        raise ValueError(f"clamp: the conormal beyond edge ({a}, {b}) is zero or lies along it")
    return np.array(given)
