"""Energies of configurations and the volumes they enclose, each with two exact variations.

Read `material`, `kirchhoff_love` ([T 2.17], the shell), `frame` and `point_tables` (what it
precomputes), `_shell_kernels` (the sums) and `_membrane_kernels` (membranes that wrinkle); then
`volume` ([T 2.27, 2.30]) and `stress`.
`hyperelastic` with `densities` takes any material; `planar_shell`, `elastic_string` and `area`
are curves. `interface` is what `shells.equilibrium` asks of all of them.
"""
