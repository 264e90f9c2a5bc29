"""coupling: structure and fluid advanced together; both are known through `protocols` only.

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Result": "protocols",
    "State": "protocols",
    "Snapshot": "protocols",
    "Simulation": "stepping.time_loop",
    "Implicit": "schemes.implicit",
    "Partitioned": "schemes.fixed_point",
    "GaussSeidel": "schemes.relaxation",
    "Constant": "schemes.relaxation",
    "Aitken": "schemes.relaxation",
    "QuasiNewton": "schemes.quasi_newton",
    "Automatic": "schemes.automatic",
    "BackwardEuler": "stepping.integrator",
    "BDF2": "stepping.integrator",
    "StepControl": "stepping.step_control",
    "Collision": "contact.self_intersection",
    "KeptOperators": "stepping.operator_reuse",
    "minimum_gap": "contact.smallest_gap",
    "contraction_forecast": "schemes.contraction",
    "contraction_measured": "schemes.contraction",
    "film_symbol": "schemes.contraction",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'coupling' has no attribute {name!r}")
    return getattr(import_module(f"coupling.{_HOME[name]}"), name)
