"""Ways to solve one coupled time step.

Read `scheme` first (what a scheme receives and returns), then `relaxation` (constant, Aitken) and
`quasi_newton` (IQN-ILS), which `fixed_point` uses for partitioned subiterations. `implicit`
solves structure and fluid together on a frozen geometry. `contraction` forecasts and measures
how fast partitioned subiterations converge, and `automatic` chooses a scheme by it.
"""
