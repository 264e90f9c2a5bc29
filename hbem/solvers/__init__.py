"""Linear solves: the saddle system of a layer with one constraint for each closed component.

Read `saddle_system`, `saddle` (LU or GMRES), `gmres` (on the true residual), `schwarz` with
`coarse_level` (two levels, for gaps), `nested` (over the solver of a smaller space) and
`preconditioner_reuse` (from one geometry to the next).
"""
