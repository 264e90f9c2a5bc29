"""Energy of the kinks of a surface of triangles, in batches of edges, with both variations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...surfaces.triangles.triangle_basis import TriangleBasis
from ..material import Material
from ..points.block_scatter import BlockScatter
from ..points.jet_sums import blocks as element_blocks
from . import _kink_kernels as kernels
from .edge_geometry import conormals, sides_of, tangents
from .edge_tables import EdgeTables, HeldSlopes, Rest, edge_tables

BLOCK = 96  # edges at a time: what their points pass on stays in the cache


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
        return KinkEnergy([b for b in self.batches if b.fixed is not None])

    @property
    def groups(self) -> list[np.ndarray]:
        """Coefficients of each edge, batch by batch."""
        return [b.sums.dofs for b in self.batches]

    def energy(self, x: np.ndarray) -> float:
        """Their energy at coefficients ``x (n_coefficients, 3)``."""
        return sum(float(self._points(b, x)[1].sum()) for b in self.batches)

    def changes(self, x: np.ndarray) -> list[np.ndarray]:
        """Kinks less the stress-free ones at the Gauss points of each batch."""
        return [self._points(b, x)[0].reshape(b.weights.shape) for b in self.batches]

    def _points(self, b: EdgeTables, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Kinks and energies at the points of a batch."""
        kinks, energies = np.empty(b.weights.size), np.empty(b.weights.size)
        kernels.energy(*_arguments(b, x, slice(None), kinks, energies))
        return kinks, energies

    def variations(
        self, x: np.ndarray, blocks: BlockScatter, first: int, data: np.ndarray | None = None
    ) -> np.ndarray:
        """First variation (3 n,); second ones are added to data, of groups from ``first`` on."""
        total = np.zeros(3 * blocks.n)
        for group, b in enumerate(self.batches, first):
            R = np.empty((*b.sums.dofs.shape, 3))
            for part in element_blocks(len(R), BLOCK):
                S, H = b.sums.zeros(part, data is not None)
                kernels.variations(*_arguments(b, x, part, data is not None, S, H))
                R[part] = b.sums.force(S, part)
                if data is not None:
                    blocks.add(data, group, b.sums.tangent(H, part), part)
            total += blocks.vector(group, R)
        return total


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


def _arguments(b: EdgeTables, x: np.ndarray, part: slice, *further: Any) -> tuple[Any, ...]:
    """Vectors at the points of some edges, and what belongs to them."""
    v = b.sums.jets(np.asarray(x, dtype=float).reshape(-1, 3), part)
    if b.fixed is not None:
        v[:, 2] = b.fixed[part].reshape(-1, 3)
    free, moduli = b.free[part].reshape(-1, 3), b.moduli[part].reshape(-1, 2)
    return v, b.weights[part].ravel(), free, moduli, b.stiffness[part].ravel(), *further


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
