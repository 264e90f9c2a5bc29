"""Nonlinear Kirchhoff-Love shell: energy and its first and second variations.

``W(theta) = 1/2 int Xi : (eps eps + D kappa kappa) dmu`` with membrane strain
``eps = (a - A) / 2`` and bending strain ``kappa = b - B`` [T 2.17, 2.18]; a, b are the first and
second fundamental forms of theta, A, B those of the reference.

Departs from [T 2.17] in the sign of eps only (it enters squared). The parametrization-free form
is evaluated in an orthonormal tangent frame of the reference: kappa has no normal components, so
all Christoffel terms of the double Gamma-gradient cancel and A is the identity.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..surfaces.form import ElementForm, Scatter
from ..surfaces.membrane_rule import MembranePoints, membrane_points
from ..surfaces.surface_basis import Jets, SurfaceBasis
from . import _shell_kernels as kernels
from .material import Material


def frame_transform(reference: Jets) -> np.ndarray:
    """Matrix G with ``N;a = G[a, alpha] N,alpha`` for an orthonormal tangent frame.

    Returns
    -------
    (n_elements, n_points, 2, 2) array
    """
    t0, t1 = reference.grad
    e0 = t0 / np.linalg.norm(t0, axis=-1, keepdims=True)
    normal = reference.normal / np.linalg.norm(reference.normal, axis=-1, keepdims=True)
    e1 = np.cross(normal, e0)
    frame = np.stack([e0, e1], axis=-1)  # columns
    T = np.stack([t0, t1], axis=-2) @ frame
    return np.linalg.inv(T)


def _apply(
    G: np.ndarray, grad: np.ndarray, hess: np.ndarray, bend: np.ndarray | None = None
) -> np.ndarray:
    """Jets (0, 1, 00, 11, 01) in the frame; leading axes of grad, hess are (d, ..., e, q, c).

    ``bend (n_elements, n_points, 2)`` holds second derivatives of the coordinates in a chart.
    """
    g = np.einsum("eqax,x...eqc->a...eqc", G, grad, optimize=True)
    full = np.stack([np.stack([hess[0], hess[2]]), np.stack([hess[2], hess[1]])])
    h = np.einsum("eqax,eqby,xy...eqc->ab...eqc", G, G, full, optimize=True)
    if bend is not None:
        h[0, 0] += bend[..., 0, None] * grad[0]
        h[1, 1] += bend[..., 1, None] * grad[1]
    return np.stack([g[0], g[1], h[0, 0], h[1, 1], h[0, 1]])


def curvature_in_frame(reference: Jets, shape: Jets) -> np.ndarray:
    """Curvature (B_00, B_11, B_01) of ``shape`` in the tangent frame of ``reference``.

    The stress-free curvature of a folded bag cut from flat cloth: ``shape`` is the flat bag on
    the same parameters.

    Returns
    -------
    (n_elements, n_points, 3) array
    """
    jets = _apply(frame_transform(reference), shape.grad, shape.hess)
    return KirchhoffLove._fundamental_forms(jets)[1]


class KirchhoffLove:
    """The shell's energy on one basis.

    Parameters
    ----------
    basis : SurfaceBasis
        Vector basis (``components=3``); its reference is the unstrained configuration.
    material : Material
    exact_reference : bool
        Unknowns are displacements from the basis' exact reference; otherwise the coefficients
        are the configuration itself.
    curvature : (n_elements, n_points, 3) array, optional
        Stress-free curvature (B_00, B_11, B_01) in the reference's frame, for a folded bag cut
        from flat cloth; default that of the reference.
    formulation : {"parametrization-free", "classical"}
        [T 2.17] or [T 2.8]; the same energy.
    chart : callable, optional
        Classical formulation in other coordinates: ``chart(s, t)`` returns first and second
        derivatives of (s, t) by their own new coordinate, each ``(..., 2)`` [T tab. 6.1].
    membrane : {"gauss", "patch"}
        Points of the membrane energy: those of the basis, or the reduced rule of
        `membrane_rule`, which does not lock.

    Raises
    ------
    ValueError
        A scalar basis, an unknown formulation or rule, a rule the surface does not allow.
    """

    def __init__(
        self,
        basis: SurfaceBasis,
        material: Material,
        *,
        exact_reference: bool = False,
        curvature: np.ndarray | None = None,
        formulation: str = "parametrization-free",
        chart: Callable | None = None,
        membrane: str = "gauss",
    ):
        if basis.components != 3:
            raise ValueError("the shell needs a vector basis: SurfaceBasis(..., components=3)")
        if formulation not in ("parametrization-free", "classical"):
            raise ValueError(f"unknown formulation {formulation!r}")
        self.basis, self.material = basis, material
        self.exact_reference = exact_reference
        reference = basis.reference
        G, bend = frame_transform(reference), None
        if formulation == "classical":
            G = np.broadcast_to(np.eye(2), G.shape)
            if chart is not None:
                slope, bend = chart(*np.asarray(basis.global_coordinates()))
                G = slope[..., None] * np.eye(2)
        functions = _apply(G, basis.grads[..., None], basis.hess[..., None], bend)[..., 0]
        self._jets = np.ascontiguousarray(np.moveaxis(functions, (0, 1), (3, 2)))
        shape = _apply(G, reference.grad, reference.hess, bend)
        first, second = self._fundamental_forms(shape)
        self._metric, self._curvature = first, second
        if curvature is not None:
            self._curvature = np.ascontiguousarray(curvature)
        metric = np.empty((*first.shape[:2], 2, 2))
        metric[..., 0, 0], metric[..., 1, 1] = first[..., 0], first[..., 1]
        metric[..., 0, 1] = metric[..., 1, 0] = first[..., 2]
        self._elasticity = np.ascontiguousarray(material.elasticity(np.linalg.inv(metric)))
        base = np.moveaxis(shape, 0, 2) if exact_reference else np.zeros((*G.shape[:2], 5, 3))
        self._base = np.ascontiguousarray(base)
        self._dofs = basis.surface.element_dofs
        scatter = Scatter(np.ascontiguousarray(basis.element_dofs.T), basis.N)
        self.force = ElementForm(lambda x: self._elements(x, False)[0], basis, 1, scatter)
        self.stiffness = ElementForm(lambda x: self._elements(x, True)[1], basis, 2, scatter)
        self._scatter = scatter
        self._weights = np.stack([basis.dx, basis.dx])
        self._points = basis.dx.shape[1]
        if membrane not in ("gauss", "patch"):
            raise ValueError(f"unknown membrane rule {membrane!r}: 'gauss' or 'patch'")
        if membrane == "patch":
            if formulation == "classical" or isinstance(basis.source, Jets):
                raise ValueError(
                    "membrane='patch' needs the parametrization-free formulation and a reference "
                    "given by coefficients or a callable"
                )
            self._add(membrane_points(basis.surface, basis.source), exact_reference)

    def _add(self, points: MembranePoints, exact_reference: bool) -> None:
        """Append the reduced membrane points; the Gauss points keep the bending energy."""
        shape = points.dx.shape
        tangents = points.reference
        G = frame_transform(Jets(tangents[0], tangents, tangents))
        jets = np.zeros((*shape, self._dofs.shape[1], 5))
        jets[..., :2] = np.einsum("eqax,xneq->eqna", G, points.grads, optimize=True)
        base = np.zeros((*shape, 5, 3))
        if exact_reference:
            base[..., :2, :] = np.einsum("eqax,xeqc->eqac", G, tangents, optimize=True)
        metric = np.broadcast_to([1.0, 1.0, 0.0], (*shape, 3))
        elasticity = np.broadcast_to(self.material.elasticity(), (*shape, 3, 3))
        self._jets = np.concatenate([self._jets, jets], axis=1)
        self._base = np.concatenate([self._base, base], axis=1)
        self._metric = np.concatenate([self._metric, metric], axis=1)
        self._curvature = np.concatenate([self._curvature, np.zeros((*shape, 3))], axis=1)
        self._elasticity = np.concatenate([self._elasticity, elasticity], axis=1)
        none = np.zeros_like(self.basis.dx)
        self._weights = np.stack(
            [
                np.concatenate([none, points.dx], axis=1),
                np.concatenate([self.basis.dx, np.zeros(shape)], axis=1),
            ]
        )

    @staticmethod
    def _fundamental_forms(shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second forms (00, 11, 01) from jets (5, n_elements, n_points, 3)."""
        t0, t1, h00, h11, h01 = shape
        normal = np.cross(t0, t1)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)

        def dots(pairs: tuple) -> np.ndarray:
            return np.stack([np.einsum("eqc,eqc->eq", a, b) for a, b in pairs], axis=-1)

        first = dots(((t0, t0), (t1, t1), (t0, t1)))
        return first, dots(((h00, normal), (h11, normal), (h01, normal)))

    def _arguments(self, x: np.ndarray) -> tuple:
        coefficients = np.ascontiguousarray(np.asarray(x, dtype=float).reshape(-1, 3))
        return (
            self._jets,
            self._base,
            self._weights,
            self._metric,
            self._curvature,
            self._elasticity,
            self.material.flexural_rigidity,
            self._dofs,
            coefficients,
        )

    def _elements(self, x: np.ndarray, tangent: bool) -> tuple[np.ndarray, np.ndarray]:
        ne, nd = self._dofs.shape[0], 3 * self._dofs.shape[1]
        R = np.empty((ne, nd))
        K = np.empty((ne, nd, nd) if tangent else (1, 1, 1))
        kernels.force_and_tangent(*self._arguments(x), tangent, R, K)
        return R, K

    @property
    def elasticity(self) -> np.ndarray:
        """Elasticity in Voigt order at the basis' points, ``(n_elements, n_points, 3, 3)``."""
        return self._elasticity[:, : self._points]

    def forms(self, x: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray, np.ndarray]:
        """Fundamental forms (00, 11, 01) in the shell's frame, ``(n_elements, n_points, 3)``.

        Returns
        -------
        (A, B), a, b
            Of the reference and of the configuration with coefficients ``x``.
        """
        local = np.asarray(x, dtype=float).reshape(-1, 3)[self._dofs]
        own = slice(self._points)  # reduced membrane points follow those of the basis
        spline = np.einsum("eqad,eac->eqdc", self._jets[:, own], local, optimize=True)
        first, second = self._fundamental_forms(np.moveaxis(self._base[:, own] + spline, 2, 0))
        return (self._metric[:, own], self._curvature[:, own]), first, second

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        """Membrane and bending energy at coefficients ``(n_coefficients, 3)``."""
        out = np.empty((self._dofs.shape[0], 2))
        kernels.energy(*self._arguments(x), out)
        membrane, bending = out.sum(axis=0)
        return float(membrane), float(bending)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """First variation W' [T 2.18a] as a dof vector ``(3 n_coefficients,)``."""
        return self._scatter.vector(self._elements(x, False)[0])

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, object]:
        """W' and W'' [T 2.18] from one pass of the kernel; W'' is a CSR matrix."""
        R, K = self._elements(x, True)
        return self._scatter.vector(R), self._scatter.matrix(K)
