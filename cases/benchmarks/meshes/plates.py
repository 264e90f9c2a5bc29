"""Bending on raw meshes: simply supported square plate, ``w = sin(pi x) sin(pi y)``.

Broken H2 seminorm and L2 norm of the error, relative, at rates p - 1 and more.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import spsolve
from skfem import LinearForm

from shells.energy.frame import frame_transform, jets_in_frame
from shells.energy.kinks.triangle_shell import TriangleShell
from shells.energy.material import Material
from shells.surfaces.triangles.triangle_basis import TriangleBasis

from ..report import Row
from .raw import interpolated, rectangle, regular_share

SIZES = (5, 10, 20, 40)  # points of a side: 68 to 3358 triangles


@dataclass(frozen=True)
class Plate:
    """Errors of one mesh."""

    triangles: int
    coefficients: int
    regular: float
    h2: float
    l2: float
    seconds: float


def plate(n: int, degree: int, seed: int = 0, stabilisation: float | None = None) -> Plate:
    """Deflection of the plate on a raw mesh of n points a side, at Poisson ratio 0.3."""
    start = time.perf_counter()
    points, triangles = rectangle(n, seed=seed)
    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, degree, lambda x: x)
    basis = TriangleBasis(surface, c, exactness=2 * degree + 4)
    material = Material(1.0, poisson_ratio=0.3)
    shell = TriangleShell(basis, material, stabilisation=stabilisation)
    free = 3 * np.setdiff1d(np.arange(surface.n_coefficients), surface.rim_coefficients) + 2
    K = shell.gradient_and_tangent(c)[1][free][:, free]
    load = LinearForm(lambda v, w: 4.0 * np.pi**4 * _exact(w.x)[0] * v[2]).assemble(basis)
    w = np.zeros(basis.N)
    w[free] = spsolve(K.tocsc(), load[free])
    seconds = time.perf_counter() - start
    found = basis.jets(w.reshape(-1, 3))
    jets = jets_in_frame(frame_transform(basis.reference), found.grad, found.hess)[2:, ..., 2]
    exact = jets_in_frame(frame_transform(basis.reference), *_parametric(basis))[2:, ..., 0]
    value = _exact(np.moveaxis(basis.reference.value, -1, 0))[0]

    def norm(h: np.ndarray) -> float:
        return float(np.sqrt(((h[0] ** 2 + h[1] ** 2 + 2.0 * h[2] ** 2) * basis.dx).sum()))

    l2 = np.sqrt(
        ((found.value[..., 2] - value) ** 2 * basis.dx).sum() / (value**2 * basis.dx).sum()
    )
    return Plate(
        surface.n_elements,
        surface.n_coefficients,
        regular_share(triangles),
        norm(jets - exact) / norm(exact),
        float(l2),
        seconds,
    )


def _exact(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The deflection and its Hessian (2, 2, ...)."""
    sx, sy = np.sin(np.pi * x[0]), np.sin(np.pi * x[1])
    mixed = np.cos(np.pi * x[0]) * np.cos(np.pi * x[1])
    hess = np.pi**2 * np.array([[-sx * sy, mixed], [mixed, -sx * sy]])
    return sx * sy, hess


def _parametric(basis: TriangleBasis) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the exact deflection by the triangles' own coordinates."""
    _, hess = _exact(np.moveaxis(basis.reference.value, -1, 0))
    t = basis.reference.grad[..., :2]
    second = np.einsum("aeqi,ijeq,beqj->abeq", t, hess, t)
    return np.zeros((2, *second.shape[2:], 1)), np.stack(
        [second[0, 0], second[1, 1], second[0, 1]]
    )[..., None]


def plate_rows(quick: bool) -> list[Row]:
    """Rows of the benchmark."""
    rows: list[Row] = []
    for degree in (3, 2):
        last: Plate | None = None
        for n in SIZES[1:3] if quick else SIZES:
            found = plate(n, degree)
            rate = None
            if last is not None:
                rate = 2.0 * np.log(last.h2 / found.h2) / np.log(found.triangles / last.triangles)
            rows.append(
                {
                    "case": f"plate, degree {degree}, {found.triangles} triangles",
                    "seconds": found.seconds,
                    "error": found.h2,
                    "reference": "closed form, broken H2",
                    "L2 error": found.l2,
                    "rate": "" if rate is None else f"{rate:.2f}",
                    "degree": degree,
                    "triangles": found.triangles,
                    "coefficients": found.coefficients,
                    "regular vertices": found.regular,
                }
            )
            last = found
    return rows
