"""Steady planar flow: Navier-Stokes on flagged elements, Stokes on the others.

Read `spaces` (Taylor-Hood on scikit-fem), `convection` (the only nonlinear term), `flow` (the
problem `MixedFlow`) and `newton` (how it is solved, with continuation). `ordering`, `pattern` and
`checked_factor` make its linear systems cheap and safe.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
