"""Configurations in balance: at rest, along a path of loads, or one time step later.

Read `structure` (the public class), then `supported_shell` (its data), `balance` (residual and
tangent), `newton` (the iteration, with the volume row eliminated) and `descent` (a merit that falls
and contact that nothing crosses, for steps); `static`, `backward_euler` ([T 6.11]) and
`energy_budget` are what a structure does, `state` what comes out. `load_paths` and `minimise` lead
to equilibria far away, `modes` tells how they vibrate and buckle;
`multigrid` and `damped_tangent` are other linear solvers.
"""
