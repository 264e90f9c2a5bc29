"""Coupling schemes by name, for scenes in space and in the plane."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from coupling.schemes.automatic import Automatic
from coupling.schemes.contraction import starting_relaxation
from coupling.schemes.fixed_point import Partitioned
from coupling.schemes.implicit import Implicit
from coupling.schemes.quasi_newton import QuasiNewton
from coupling.schemes.relaxation import Aitken, Constant, GaussSeidel
from coupling.schemes.scheme import Scheme

from ..sections import Coupling

# Measured: partitioned schemes converge up to these contractions.
LIMITS = {"gauss-seidel": 1.0, "aitken": 20.0, "iqn-ils": 200.0}
PASSES, SUBITERATIONS = 6, 30  # iterations allowed where the scene says "automatic"


def scheme(coupling: Coupling, rho: float, dt: float, *, cheap: float = 1.0) -> Scheme:
    """The scheme a scene names; the implicit ones and "auto" need a load linear in the velocity.

    Parameters
    ----------
    coupling : Coupling
    rho : float
        Contraction of plain subiterations at the step ``dt``, a priori.
    cheap : float
        Largest rho at which "auto" takes IQN-ILS.
    """
    first = starting_relaxation(coupling.relaxation, rho)
    implicit, iqn = Implicit(coupling.dense_limit), Partitioned(QuasiNewton(first))
    schemes: Mapping[str, Callable[[], Scheme]] = {
        "implicit": lambda: implicit,
        "semi-implicit": lambda: Implicit(coupling.dense_limit, passes=1),
        "auto": lambda: Automatic(rho / dt, iqn, implicit, cheap),
        "iqn-ils": lambda: iqn,
        "aitken": lambda: Partitioned(Aitken(first)),
        "constant": lambda: Partitioned(Constant(coupling.relaxation)),
        "gauss-seidel": lambda: Partitioned(GaussSeidel()),
    }
    return schemes[coupling.scheme]()


def iterations(coupling: Coupling) -> int:
    """Iterations allowed in a step."""
    implicit = coupling.scheme in ("implicit", "semi-implicit")
    return coupling.max_iterations or (PASSES if implicit else SUBITERATIONS)
