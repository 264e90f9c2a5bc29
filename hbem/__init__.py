"""hbem: boundary integral operators of Stokes flow on polynomial surface patches.

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "BezierPatches": "surfaces.patches",
    "SurfacePatches": "surfaces.patches",
    "union": "surfaces.patches",
    "QuadratureOrders": "surfaces.quadrature",
    "SampledSurface": "surfaces.surface_points",
    "sample": "surfaces.surface_points",
    "Compression": "compression.choice",
    "SingleLayer": "layers.layer",
    "DoubleLayer": "layers.double_layer",
    "FlowField": "flows.field",
    "flow_field": "flows.field",
    "DenseSaddle": "solvers.saddle",
    "IterativeSaddle": "solvers.saddle",
    "KrylovResult": "solvers.saddle",
    "saddle": "solvers.saddle",
    "StokesFlow": "flows.stokes_flow",
    "SurfaceTraction": "flows.stokes_flow",
    "SurfaceError": "surfaces.topology",
    "closed_components": "surfaces.topology",
    "Budget": "accuracy",
    "budget": "accuracy",
    "two_level_schwarz": "solvers.schwarz",
    "EnclosedStokes": "flows.enclosed_flow",
    "Traction": "traction",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'hbem' has no attribute {name!r}")
    return getattr(import_module(f"hbem.{_HOME[name]}"), name)
