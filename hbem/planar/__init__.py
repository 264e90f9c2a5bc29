"""hbem.planar: boundary integrals on polygons, everything analytic in the inner variable.

Read `polygon` (a membrane and its inlet as a polygon), `stokes` (any viscosity ratio),
`potential` (with Bernoulli's pressure), `contact` (the recycled double-layer force) and
`polygon_stokes` (the field inside). Names load on first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
