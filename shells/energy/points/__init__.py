"""Energies at quadrature points and their sums over the functions of elements.

``point_tables.py`` (functions, reference and stiffness at points), ``point_energy.py`` (a shell's
energy there), ``jet_sums.py`` (from points to elements), ``block_scatter.py`` (into a matrix).
"""
