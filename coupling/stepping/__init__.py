"""Advancing a coupled problem in time.

Read `time_loop` first: `Simulation` and the loop that accepts or rejects steps as a whole. It
asks `integrator` (backward Euler, BDF2) what a step starts from, `step_control` how long the next
one is, and writes rows by `history_row`. `operator_reuse` saves assemblies of the fluid.
"""
