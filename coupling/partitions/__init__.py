"""The flow cut into a Navier-Stokes and a Stokes part that meet at an interface.

Read `substructure` (the cut, both parts solved at once), `interface_iterations` (solved in turns
[T 7.18]), then the Stokes part by boundary elements: `boundary_traces`, `boundary_pieces`,
`boundary_stokes` and its adaptive loop `boundary_loop`. Boundary operators are arguments.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
