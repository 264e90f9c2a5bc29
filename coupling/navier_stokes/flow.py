"""Steady flow with convection on flagged elements only: Navier-Stokes there, Stokes elsewhere.

``a(u, v) + b(v, p) + b(u, q) + c_N(u, u, v) = 0`` [T 7.11], u prescribed on the Dirichlet part,
no traction elsewhere. The viscous form is ``(grad u, grad v) / Re`` [T 7.8] or, for partitioned
use, that of the full stress ``2 (eps(u), eps(v)) / Re``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import bmat, csr_array
from skfem import BilinearForm, FacetBasis, Mesh

from .checked_factor import Factor
from .convection import Convection
from .pattern import Pattern, pattern
from .spaces import FlowSpace, taylor_hood

Profile = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class MixedFlow:
    """A flow problem; the model of each element is an argument of its methods.

    Parameters
    ----------
    space : FlowSpace
    reynolds : float
    fixed : (n,) bool array
        Prescribed unknowns.
    values : (n,) array
        What they are prescribed to (0 elsewhere).
    viscous, saddle : (n, n) sparse arrays
        The forms Re a and b.
    convection : Convection
    pattern : Pattern
    viscous_data, saddle_data : (nnz,) arrays
        The forms on the pattern.
    """

    space: FlowSpace
    reynolds: float
    fixed: np.ndarray
    values: np.ndarray
    viscous: csr_array
    saddle: csr_array
    convection: Convection
    pattern: Pattern
    viscous_data: np.ndarray
    saddle_data: np.ndarray

    def at(self, reynolds: float) -> MixedFlow:
        """Give the same problem at another Reynolds number.

        Parameters
        ----------
        reynolds : float

        Returns
        -------
        MixedFlow
        """
        return replace(self, reynolds=reynolds)

    def skew(self) -> MixedFlow:
        """Give the same problem with the skew-symmetric convection of [T 7.13].

        Returns
        -------
        MixedFlow
        """
        return replace(self, convection=replace(self.convection, skew=True))

    def with_wind(self, x: np.ndarray) -> MixedFlow:
        """Give the linear problem whose convecting velocity is that of a field.

        Parameters
        ----------
        x : (n,) array

        Returns
        -------
        MixedFlow
        """
        return replace(self, convection=replace(self.convection, wind=x))

    @property
    def nowhere(self) -> np.ndarray:
        """Flags of Stokes flow in the whole domain."""
        return np.zeros(self.space.n_elements, dtype=bool)

    @property
    def everywhere(self) -> np.ndarray:
        """Flags of Navier-Stokes flow in the whole domain."""
        return np.ones(self.space.n_elements, dtype=bool)

    def residual(self, x: np.ndarray, flagged: np.ndarray) -> np.ndarray:
        """Test ``F - N(x)`` with all functions, those of prescribed unknowns too.

        Parameters
        ----------
        x : (n,) array
        flagged : (n_elements,) bool array
            Elements with convection.

        Returns
        -------
        (n,) array
        """
        linear = self.viscous @ x / self.reynolds + self.saddle @ x
        return -linear - self.convection.vector(x, flagged)

    def free_residual(self, x: np.ndarray, flagged: np.ndarray) -> np.ndarray:
        """Give the residual of the free unknowns in their order of elimination.

        Parameters
        ----------
        x : (n,) array
        flagged : (n_elements,) bool array

        Returns
        -------
        (n_free,) array
        """
        return self.residual(x, flagged)[self.pattern.order]

    def tangent(self, x: np.ndarray, flagged: np.ndarray) -> Factor:
        """Factorise the derivative of N at a field.

        Parameters
        ----------
        x : (n,) array
        flagged : (n_elements,) bool array

        Returns
        -------
        Factor
            Of the free unknowns in their order of elimination.
        """
        data = self.viscous_data / self.reynolds + self.saddle_data
        rows = np.flatnonzero(flagged)
        if rows.size:
            self.pattern.add(data, rows, self.convection.matrices(x, rows))
        return Factor(self.pattern.matrix(data))

    def extend(self, free: np.ndarray) -> np.ndarray:
        """Extend free unknowns by zero where velocities are prescribed.

        Parameters
        ----------
        free : (n_free,) array
            In their order of elimination.

        Returns
        -------
        (n,) array
        """
        x = np.zeros(self.space.n)
        x[self.pattern.order] = free
        return x


def mixed_flow(
    mesh: Mesh,
    dirichlet: Mapping[str, Profile],
    *,
    reynolds: float,
    outlet: str | None = None,
    stress: bool = False,
    degree: int = 2,
) -> MixedFlow:
    """Pose a flow problem on a mesh.

    Parameters
    ----------
    mesh : skfem.Mesh
        With named boundaries.
    dirichlet : mapping
        Velocity ``(2, m) -> (2, m)`` on named boundaries; later entries win at corners.
    reynolds : float
    outlet : str, optional
        Boundary without traction.
    stress : bool
        Viscous form of the full stress. The outlet keeps the condition of the other form
        (that of a developed profile): the difference is subtracted there.
    degree : int
        Of the velocity, see `taylor_hood`.

    Returns
    -------
    MixedFlow

    Raises
    ------
    ValueError
        Unknown boundary, or a Reynolds number that is not positive.
    """
    known = mesh.boundaries or {}
    if missing := [name for name in (*dirichlet, *filter(None, [outlet])) if name not in known]:
        raise ValueError(f"the mesh has no boundary {missing}; it has {sorted(known)}")
    if not reynolds > 0.0:
        raise ValueError(f"a Reynolds number is positive, got {reynolds}")
    space = taylor_hood(mesh, degree)
    fixed, values = dirichlet_values(space, dirichlet)
    facets = None
    if outlet:
        facets = FacetBasis(mesh, space.velocity.elem, facets=outlet, intorder=3 * degree)
    viscous, saddle = _viscous(space, facets if stress else None, stress), _saddle(space)
    places = pattern(space, fixed)
    return MixedFlow(
        space=space,
        reynolds=reynolds,
        fixed=fixed,
        values=values,
        viscous=viscous,
        saddle=saddle,
        convection=Convection(space, outlet=facets),
        pattern=places,
        viscous_data=places.data(viscous),
        saddle_data=places.data(saddle),
    )


def dirichlet_values(
    space: FlowSpace, dirichlet: Mapping[str, Profile]
) -> tuple[np.ndarray, np.ndarray]:
    """Flags and values ``(n,)`` of the prescribed velocities of a space."""
    fixed, values = np.zeros(space.n, dtype=bool), np.zeros(space.n)
    for name, profile in dirichlet.items():
        dofs = space.velocity.get_dofs(name).flatten()
        velocity = profile(space.velocity.doflocs[:, dofs])
        for i in range(2):
            fixed[dofs + i * space.n_velocity] = True
            values[dofs + i * space.n_velocity] = velocity[i]
    return fixed, values


@BilinearForm
def _laplace(u, v, w):
    return u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1]


def _partial(i: int, j: int) -> BilinearForm:
    """``(d_j u, d_i v)``."""
    return BilinearForm(lambda u, v, w: u.grad[j] * v.grad[i])


def _viscous(space: FlowSpace, outlet: FacetBasis | None, stress: bool) -> csr_array:
    """Re a(u, v), with zero rows for the pressure."""
    laplace = _laplace.assemble(space.velocity)
    blocks = [[laplace, None], [None, laplace]]
    if stress:
        # 2 eps : eps = grad u : grad v + (grad u)^T : grad v, the second is (d_i u_j, d_j v_i)
        blocks = [[_partial(j, i).assemble(space.velocity) for j in range(2)] for i in range(2)]
        blocks[0][0] = blocks[0][0] + laplace
        blocks[1][1] = blocks[1][1] + laplace
        if outlet is not None:
            for i in range(2):
                for j in range(2):
                    blocks[i][j] = blocks[i][j] - _transposed_traction(i, j).assemble(outlet)
    zero = csr_array((space.pressure.N, space.pressure.N))
    blocks = [[*blocks[0], None], [*blocks[1], None], [None, None, zero]]
    return csr_array(bmat(blocks))


def _transposed_traction(i: int, j: int) -> BilinearForm:
    """``d_i u_j n_j v_i`` on a boundary."""
    return BilinearForm(lambda u, v, w: u.grad[i] * w.n[j] * v)


def _saddle(space: FlowSpace) -> csr_array:
    """``b(v, p) + b(u, q)`` with ``b(u, p) = -(div u, p)`` [T 7.9]."""
    b = [
        BilinearForm(lambda u, q, w, i=i: -u.grad[i] * q).assemble(space.velocity, space.pressure)
        for i in range(2)
    ]
    return csr_array(bmat([[None, None, b[0].T], [None, None, b[1].T], [b[0], b[1], None]]))
