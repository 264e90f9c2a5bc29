"""Stokes flows: boundary velocities in, tractions, forces and fields out.

Read `formulation` ([T 5.4], once for all), then `stokes_flow` and `surface_traction` (closed
bodies), or `enclosed_problem`, `enclosed_flow` and `enclosed_operator` (a membrane's fluid);
`admissible` refuses what cannot be solved; `field` and `streamlines` look into the flow.
"""
