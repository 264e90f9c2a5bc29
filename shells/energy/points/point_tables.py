"""What an energy needs at its quadrature points: functions, reference and stiffness, ready to use.

A shell computes these once; afterwards every evaluation of the energy is one pass over them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...surfaces.element_basis import ElementBasis
from ...surfaces.jets import Jets
from ...surfaces.membrane_rule import membrane_points
from ...surfaces.smoothness import check_smooth
from ...surfaces.surface import Surface
from ..frame import frame_transform, fundamental_forms, jets_in_frame
from ..material import Material


@dataclass(frozen=True)
class PointTables:
    """Quadrature points of all elements, as the kernels take them.

    Attributes
    ----------
    jets : (n_elements, n_points, r, n_functions) array
        Derivatives 0, 1, 00, 11, 01 of the basis functions in the frame; r = 2 without bending.
    base : (n_elements, n_points, r, 3) array
        Those of the exact reference where unknowns are displacements, else zero.
    weights : (2, n_elements, n_points) array
        Reference areas for membrane and for bending energy.
    metric, curvature : (n_elements, n_points, 3) array
        First and second form (00, 11, 01) of the stress-free shell.
    elasticity : (n_elements, n_points, 3, 3) array
        In Voigt order.
    """

    jets: np.ndarray
    base: np.ndarray
    weights: np.ndarray
    metric: np.ndarray
    curvature: np.ndarray
    elasticity: np.ndarray

    @property
    def membrane(self) -> PointTables:
        """What membrane energy alone needs."""
        first = np.ascontiguousarray(self.jets[:, :, :2])
        return replace(self, jets=first, base=self.base[:, :, :2])


def check_bending(surface: Surface, material: Material, seams: bool) -> None:
    """Refuse bending on a surface that is not C1; a membrane may have kinks.

    Raises
    ------
    ValueError
        Degree 1, or a C0 knot line where no seams are meant.
    """
    if material.flexural_rigidity > 0.0:
        check_smooth(surface, seams)


def point_tables(
    basis: ElementBasis,
    material: Material,
    *,
    exact_reference: bool = False,
    curvature: np.ndarray | None = None,
    formulation: str = "parametrization-free",
    chart: Callable | None = None,
) -> PointTables:
    """Tables at the points of a basis; the parameters are those of `KirchhoffLove`."""
    reference = basis.reference
    G, bend = frame_transform(reference), None
    if formulation == "classical":
        G = np.broadcast_to(np.eye(2), G.shape)
        if chart is not None:
            slope, bend = chart(*np.asarray(basis.global_coordinates()))
            G = slope[..., None] * np.eye(2)
    functions = jets_in_frame(G, basis.grads[..., None], basis.hess[..., None], bend)[..., 0]
    shape = jets_in_frame(G, reference.grad, reference.hess, bend)
    first, second = fundamental_forms(shape)
    metric = np.empty((*first.shape[:2], 2, 2))
    metric[..., 0, 0], metric[..., 1, 1] = first[..., 0], first[..., 1]
    metric[..., 0, 1] = metric[..., 1, 0] = first[..., 2]
    base = np.moveaxis(shape, 0, 2) if exact_reference else np.zeros((*G.shape[:2], 5, 3))
    return PointTables(
        np.ascontiguousarray(functions.transpose(2, 3, 0, 1)),
        np.ascontiguousarray(base),
        np.stack([basis.dx, basis.dx]),
        first,
        second if curvature is None else np.ascontiguousarray(curvature),
        np.ascontiguousarray(material.elasticity(np.linalg.inv(metric))),
    )


def reduced_membrane(basis: ElementBasis, material: Material, exact_reference: bool) -> PointTables:
    """Reduced membrane points, whose weights of bending are zero.

    Raises
    ------
    ValueError
        A surface that does not allow the rule (see `membrane_points`), or a reference given by
        its jets alone, which are not known at other points.
    """
    if isinstance(basis.source, Jets):
        raise ValueError("membrane='reduced' needs a reference given by coefficients or a callable")
    points = membrane_points(basis.surface, basis.source)
    shape, tangents = points.dx.shape, points.reference
    G = frame_transform(Jets(tangents[0], tangents, tangents))
    base = np.zeros((*shape, 2, 3))
    if exact_reference:
        base = np.einsum("eqax,xeqc->eqac", G, tangents, optimize=True)
    return PointTables(
        np.ascontiguousarray(np.einsum("eqax,xneq->eqan", G, points.grads, optimize=True)),
        base,
        np.stack([points.dx, np.zeros(shape)]),
        np.tile([1.0, 1.0, 0.0], (*shape, 1)),
        np.zeros((*shape, 3)),
        np.tile(material.elasticity(), (*shape, 1, 1)),
    )
