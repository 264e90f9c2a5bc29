"""Boundary integrals: `suite.py` (exact flows, orders, eigenvalues), then what is hard.

``near_rules.py`` (points close to an element, speed), ``gaps.py`` (thin gaps, preconditioners,
collapsed corners, the rules behind `hbem.accuracy`). ``views.py``: the tables.
"""
