"""Surfaces and curves as spline spaces, and as scikit-fem bases.

Read `splines` (one variable), `tensor_surface` and `spline_surface` (two variables, poles,
restrictions) or `pillow` (closed without poles), then `surface_basis` (scikit-fem meets them),
`form` (assembly of element arrays), `membrane_rule` (points that do not lock) and `smoothness`
(surfaces that cannot bend). `curve` is the plane counterpart. Nothing here knows of energies.
"""
