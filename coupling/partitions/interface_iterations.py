"""Partitioned iterations between a Navier-Stokes and a Stokes part [T 7.18].

One pass: the Navier-Stokes part with velocities prescribed on G, then the Stokes part under its
traction. `Transmission.THESIS` keeps the Navier-Stokes part's own stiffness on G in the second
solve: with a nodal lift that is a block Gauss-Seidel iteration, not Dirichlet-Neumann. The fixed
point of interface velocities is relaxed by `coupling.schemes`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.newton import solve
from ..navier_stokes.pattern import pattern
from ..schemes.fixed_point import iterate
from ..schemes.relaxation import M, Relaxation
from .substructure import Parts, whole_tangent


class Transmission(Enum):
    """How the traction enters the Stokes solve."""

    THESIS = "block Gauss-Seidel [T 7.18]"
    DIRICHLET_NEUMANN = "Dirichlet-Neumann"


@dataclass(frozen=True)
class PartitionedSolution:
    """Result of a partitioned solve.

    Parameters
    ----------
    inner, outer : arrays
        Fields of both parts.
    iterations : int
        Passes over both parts.
    converged : bool
    """

    inner: np.ndarray
    outer: np.ndarray
    iterations: int
    converged: bool


class InterfaceMap:
    """The fixed-point map of interface velocities; holds the fields of its last evaluation."""

    def __init__(self, parts: Parts, transmission: Transmission):
        self.parts, self.transmission = parts, transmission
        inner, trace = parts.inner, parts.inner_trace
        fixed = inner.fixed.copy()
        fixed[trace] = True
        self._dirichlet = _with_prescribed(inner, fixed)
        self._stokes = whole_tangent(parts.outer)
        self._free = np.flatnonzero(~parts.outer.fixed)
        self.inner = inner.values.copy()
        self.outer = parts.outer.values.copy()

    def __call__(self, velocity: np.ndarray) -> np.ndarray:
        """Interface velocities after one pass, ``(m,) -> (m,)``; NaN if a solve fails."""
        parts = self.parts
        values = parts.inner.values.copy()
        values[parts.inner_trace] = velocity
        problem = replace(self._dirichlet, values=values)
        found = solve(problem, problem.everywhere, self.inner)
        if not found.ok:
            return np.full_like(velocity, np.nan)
        self.inner = found.x
        self.outer = self._second(velocity)
        return self.outer[parts.outer_trace]

    def _second(self, velocity: np.ndarray) -> np.ndarray:
        """Stokes part under the traction of the Navier-Stokes part."""
        parts = self.parts
        matrix, x = self._stokes, parts.outer.values.copy()
        load = parts.outer.residual(x, parts.outer.nowhere)
        if self.transmission is Transmission.THESIS:
            own, force = self._stiffness(velocity)
            matrix = matrix + self._embedded(own)
        else:
            inner = parts.inner
            force = inner.residual(self.inner, inner.everywhere)[parts.inner_trace]
        load[parts.outer_trace] += force
        free = self._free
        lu = splu(csc_array(matrix[free][:, free]))
        x[free] += lu.solve(load[free])
        return x

    def _stiffness(self, velocity: np.ndarray) -> tuple[csr_array, np.ndarray]:
        """The inner part's rows on G: matrix for new velocities there, force of the rest.

        Convection is linear in the new velocities v: ``c(u + v_old, v) + c(v, u) + c(u, u)``,
        u the inner field without its interface values.
        """
        inner, trace = self.parts.inner, self.parts.inner_trace
        u = self.inner.copy()
        u[trace] = 0.0
        old = u.copy()
        old[trace] = velocity
        both = whole_tangent(inner, u) - whole_tangent(inner.with_wind(u), u)
        carried = whole_tangent(inner.with_wind(old), old)
        matrix = (both + carried)[trace][:, trace]
        return matrix, inner.residual(u, inner.everywhere)[trace]

    def _embedded(self, own: csr_array) -> csr_array:
        trace, n = self.parts.outer_trace, self.parts.outer.space.n
        coo = own.tocoo()
        return csr_array((coo.data, (trace[coo.row], trace[coo.col])), shape=(n, n))


def _with_prescribed(flow: MixedFlow, fixed: np.ndarray) -> MixedFlow:
    """The problem with other prescribed unknowns."""
    places = pattern(flow.space, fixed)
    return replace(
        flow,
        fixed=fixed,
        pattern=places,
        viscous_data=places.data(flow.viscous),
        saddle_data=places.data(flow.saddle),
    )


def solve_partitioned(
    parts: Parts,
    relaxation: Relaxation[M],
    *,
    transmission: Transmission = Transmission.THESIS,
    tolerance: float = 1e-11,
    max_iterations: int = 60,
    watch: Callable[[np.ndarray], None] | None = None,
) -> PartitionedSolution:
    """Solve both parts in turns, from rest [T 7.18].

    Parameters
    ----------
    parts : Parts
    relaxation : Relaxation
        `coupling.GaussSeidel`, `coupling.Aitken` or `coupling.QuasiNewton`.
    transmission : Transmission
    tolerance : float
        Change of interface velocities relative to their size after the first pass.
    max_iterations : int
    watch : callable, optional
        Called with the interface velocities of each pass.

    Returns
    -------
    PartitionedSolution
    """
    interface = InterfaceMap(parts, transmission)
    start = interface(np.zeros(parts.inner_trace.size))
    if not np.all(np.isfinite(start)):
        return PartitionedSolution(interface.inner, interface.outer, 1, False)

    def function(x: np.ndarray) -> np.ndarray:
        if watch is not None:
            watch(x)
        return interface(x)

    _, count, done = iterate(
        function,
        start,
        relaxation,
        tolerance=tolerance * float(np.linalg.norm(start)),
        max_iterations=max_iterations,
    )
    return PartitionedSolution(interface.inner, interface.outer, count + 1, done)
