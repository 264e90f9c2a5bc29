"""Coupling: `suite.py` lists the parts, ``posed.py`` makes scenes ready to start anywhere.

``contraction.py`` (rho three ways), ``schemes.py`` (all schemes from the same state), ``rates.py``
(time and space), ``capsule.py`` (against theory), ``stress.py`` (runs that ask for trouble, killed
and resumed). ``views.py``: the tables.
"""
