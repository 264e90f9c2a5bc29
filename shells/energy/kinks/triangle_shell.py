"""Kirchhoff-Love shell on continuous Bezier triangles, on any triangulation.

``W = sum over triangles of [T 2.17] + sum over edges of int (-M theta + eta D theta^2 / (2 h)) ds``
with the change theta of the kink, the moment M across the edge, a mean weighted by the areas of
its triangles, and ``h = (A1 + A2) / |e|``: an interior penalty (of plates: Engel et al. 2002,
Brenner and Sung 2005). It converges on raw triangulations, where smooth bases with irregular
vertices do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ...surfaces.triangles.triangle_basis import TriangleBasis
from ..frame import curvature_in_frame
from ..kirchhoff_love import KirchhoffLove
from ..material import Material
from ..points.block_scatter import BlockScatter
from .edge_tables import HeldSlopes, Rest
from .kink_energy import KinkEnergy, kink_energy

STABILISATION = {2: 8.0, 3: 20.0}  # eta by degree: twice what `edge_tables` proves enough


class TriangleShell(KirchhoffLove):
    """The shell's energy on triangles: `KirchhoffLove` with slopes tied across edges.

    Without flexural rigidity no edge carries energy (``edges`` is empty). At the rim the shell
    turns freely (hinged where the extraction holds its trace) unless ``clamp`` holds its slope.

    Parameters
    ----------
    basis : TriangleBasis
        Its reference given by coefficients, where there is flexural rigidity.
    material : Material
    curvature : (n_coefficients, 3) array, optional
        Configuration whose curvature and kinks are free of stress, such as the flat bag of a
        folded one; default the reference.
    compression_share : float
        As in `KirchhoffLove`.
    stabilisation : float, optional
        eta; default 8 at degree 2, 20 at degree 3.
    kinks : float, (n_edges,) or (n_edges, degree + 1) array, optional
        Stress-free kinks in radians (creases that have set), as `kink_angles` measures them; 0
        wants all edges smooth. Default those of ``curvature`` or of the reference.
    soft : (n_edges,) array, optional
        Share in [0, 1] of the bending stiffness that ties each edge: 0 is a fold line that turns
        freely, 1 (default) the material.
    clamp : int array, HeldSlopes or sequence of HeldSlopes, optional
        Rim edges whose slope is held as in the reference or in given directions: clamps, planes of
        symmetry.

    Attributes
    ----------
    edges : (n,) int array
        Edges that carry energy, in the order of `change_of_kinks`.

    Raises
    ------
    ValueError
        A basis of splines, what `KirchhoffLove` refuses, arrays of other shapes, shares outside
        [0, 1], a clamp that is no rim edge, or a reference of jets alone.
    """

    basis: TriangleBasis

    def __init__(
        self,
        basis: TriangleBasis,
        material: Material,
        *,
        curvature: np.ndarray | None = None,
        compression_share: float = 1.0,
        stabilisation: float | None = None,
        kinks: np.ndarray | float | None = None,
        soft: np.ndarray | None = None,
        clamp: np.ndarray | HeldSlopes | Sequence[HeldSlopes] | None = None,
    ):
        if basis.surface.shape != "triangle":
            raise ValueError("TriangleShell takes a TriangleBasis; splines take KirchhoffLove")
        shape = None if curvature is None else basis.jets(curvature)
        super().__init__(
            basis,
            material,
            seams=True,
            curvature=None if shape is None else curvature_in_frame(basis.reference, shape),
            compression_share=compression_share,
        )
        self.kinks = KinkEnergy([])
        if material.flexural_rigidity > 0.0:
            eta = STABILISATION[basis.surface.degree] if stabilisation is None else stabilisation
            rest = _rest(basis, curvature, kinks)
            self.kinks = kink_energy(basis, material, rest, eta, soft, _held(clamp))
        self.edges = self.kinks.edges
        groups = [basis.surface.element_dofs, *self.kinks.groups]
        self._blocks = BlockScatter(groups, basis.surface.n_coefficients)

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        # kinks count as bending
        membrane, bending = super().energy(x)
        return membrane, bending + self.kinks.energy(x)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        return super().gradient(x) + self.kinks.variations(x, self._blocks, 1)

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        R, data = self._with_tangents(x)
        kinks = self.kinks.variations(x, self._blocks, 1, data)
        return self._blocks.vector(0, R) + kinks, self._blocks.matrix(data)

    @cached_property
    def grounding(self) -> csr_matrix | None:
        held = self.kinks.held
        if not held.batches:
            return None
        blocks = BlockScatter(held.groups, self.basis.surface.n_coefficients)
        data = blocks.zeros()
        held.variations(np.asarray(self.basis.source), blocks, 0, data)
        return blocks.matrix(data)

    def change_of_kinks(self, x: np.ndarray) -> np.ndarray:
        """Kinks less the stress-free ones at the Gauss points of ``edges``: what the mesh leaves.

        Parameters
        ----------
        x : (n_coefficients, 3) array

        Returns
        -------
        (n, degree + 1) array
            Signed, in radians.
        """
        none = np.empty((0, self.basis.surface.degree + 1))
        return np.concatenate([none, *self.kinks.changes(x)])


def _rest(
    basis: TriangleBasis,
    curvature: np.ndarray | None,
    kinks: np.ndarray | float | None,
) -> Rest:
    """The stress-free shell of the options."""
    if not isinstance(basis.source, np.ndarray):
        raise ValueError("triangles that bend need a reference of coefficients, not of jets alone")
    reference = np.asarray(basis.source, dtype=float)
    curved = reference if curvature is None else np.asarray(curvature, dtype=float)
    if kinks is not None:
        shape = (len(basis.surface.graph.triangles), basis.surface.degree + 1)
        kinks = np.asarray(kinks, dtype=float)
        if kinks.shape not in ((), shape[:1], shape):
            raise ValueError(f"kinks: expected {shape[:1]} or {shape}, got {kinks.shape}")
        kinks = np.broadcast_to(kinks[:, None] if kinks.ndim == 1 else kinks, shape)
    return Rest(reference, curved, kinks, basis.dx.sum(axis=1))


def _held(
    clamp: np.ndarray | HeldSlopes | Sequence[HeldSlopes] | None,
) -> Sequence[HeldSlopes]:
    if clamp is None:
        return []
    if isinstance(clamp, HeldSlopes):
        return [clamp]
    return [HeldSlopes(clamp)] if isinstance(clamp, np.ndarray) else clamp
