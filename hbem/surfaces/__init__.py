"""Surfaces: patches with a density basis, their quadrature points, and whether they are closed.

Read `patches` (what a surface is), `bernstein`, `quadrature` (all orders), `configuration` (control
points about an origin), `surface_points` (a configuration at its points), `subdivision` (nearly
flat pieces of elements for the near rules), `triangles`, `topology` (closed? outward? how many?)
and `narrowest_gap`.
"""
