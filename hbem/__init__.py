"""hbem: boundary integral operators of Stokes flow on polynomial surface patches.

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "BezierPatches": "patches",
    "SurfacePatches": "patches",
    "union": "patches",
    "QuadratureOrders": "quadrature",
    "SampledSurface": "sampling",
    "sample": "sampling",
    "Compression": "compression",
    "SingleLayer": "single_layer",
    "DoubleLayer": "double_layer",
    "FlowField": "evaluate",
    "flow_field": "evaluate",
    "DenseSaddle": "krylov",
    "IterativeSaddle": "krylov",
    "KrylovResult": "krylov",
    "saddle": "krylov",
    "StokesFlow": "flow",
    "SurfaceTraction": "flow",
    "SurfaceError": "topology",
    "closed_components": "topology",
    "Budget": "accuracy",
    "budget": "accuracy",
    "two_level_schwarz": "preconditioner",
    "EnclosedStokes": "enclosed_flow",
    "Traction": "enclosed_operator",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'hbem' has no attribute {name!r}")
    return getattr(import_module(f"hbem.{_HOME[name]}"), name)
