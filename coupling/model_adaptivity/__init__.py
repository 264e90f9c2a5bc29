"""Goal-oriented model adaptivity: Navier-Stokes where a goal needs it, Stokes elsewhere [T ch. 7].

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "taylor_hood": "!!coupling.navier_stokes.spaces",
    "mixed_flow": "!!coupling.navier_stokes.flow",
    "MixedFlow": "!!coupling.navier_stokes.flow",
    "solve": "!!coupling.navier_stokes.newton",
    "robust": "!!coupling.navier_stokes.newton",
    "region": "goals",
    "vorticity": "goals",
    "kinetic_energy": "goals",
    "point_value": "goals",
    "traction": "goals",
    "estimate": "error_estimate",
    "marked": "marking",
    "Strategy": "adaptive_loop",
    "adapt": "adaptive_loop",
    "full_model": "adaptive_loop",
    "refinements": "mesh_adaptivity",
    "cut": "!!coupling.partitions.substructure",
    "monolithic": "!!coupling.partitions.substructure",
    "partitioned": "!!coupling.partitions.interface_iterations",
    "boundary_flow": "!!coupling.partitions.boundary_stokes",
    "adapt_boundary": "!!coupling.partitions.boundary_loop",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'coupling.model_adaptivity' has no attribute {name!r}")
    return getattr(import_module(f"coupling.model_adaptivity.{_HOME[name]}"), name)
