"""Energies of configurations and the volumes they enclose, each with two exact variations.

Read `material`, `kirchhoff_love` ([T 2.17], the shell), `frame` and `points` (what it
precomputes, and the sums), `_shell_kernels` (its energy at points) and `_membrane_kernels`
(membranes that wrinkle); then `volume` ([T 2.27, 2.30]) and `stress`.
`hyperelastic` with `densities` takes any material; `planar_shell`, `elastic_string` and `area`
are curves. `interface` is what `shells.equilibrium` asks of all of them.
"""
