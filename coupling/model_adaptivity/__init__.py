"""Goal-oriented model adaptivity: Navier-Stokes where a goal needs it, Stokes elsewhere [T ch. 7].

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "taylor_hood": "spaces",
    "mixed_flow": "mixed_flow",
    "MixedFlow": "mixed_flow",
    "solve": "newton",
    "robust": "newton",
    "region": "goals",
    "vorticity": "goals",
    "kinetic_energy": "goals",
    "point_value": "goals",
    "traction": "goals",
    "estimate": "estimate",
    "marked": "marking",
    "Strategy": "loop",
    "adapt": "loop",
    "full_model": "loop",
    "refinements": "mesh_adaptivity",
    "cut": "substructure",
    "monolithic": "substructure",
    "partitioned": "partitioned",
    "boundary_flow": "boundary_stokes",
    "adapt_boundary": "boundary_loop",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'coupling.model_adaptivity' has no attribute {name!r}")
    return getattr(import_module(f"coupling.model_adaptivity.{_HOME[name]}"), name)
