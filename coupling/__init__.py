"""coupling: structure and fluid advanced together; both are known through `protocols` only.

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Result": "protocols",
    "State": "protocols",
    "Snapshot": "protocols",
    "Simulation": "time_loop",
    "Implicit": "implicit",
    "Partitioned": "fixed_point",
    "GaussSeidel": "relaxation",
    "Constant": "relaxation",
    "Aitken": "relaxation",
    "QuasiNewton": "quasi_newton",
    "Automatic": "automatic",
    "BackwardEuler": "integrator",
    "BDF2": "integrator",
    "StepControl": "step_control",
    "Collision": "collision",
    "KeptOperators": "kept",
    "minimum_gap": "contact",
    "contraction_forecast": "stability",
    "contraction_measured": "stability",
    "film_symbol": "stability",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'coupling' has no attribute {name!r}")
    return getattr(import_module(f"coupling.{_HOME[name]}"), name)
