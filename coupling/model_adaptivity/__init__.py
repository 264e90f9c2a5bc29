"""Goal-oriented model adaptivity: Navier-Stokes where a goal needs it, Stokes elsewhere [T ch. 7].

Read `goals` (what is to be computed), `error_estimate` (what Stokes flow costs it, and where),
`marking` (which elements change their model), then `adaptive_loop`, which puts them together.
`mesh_adaptivity` refines meshes so that discretisation stays below the modelling error. The flows
come from `coupling.navier_stokes`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
