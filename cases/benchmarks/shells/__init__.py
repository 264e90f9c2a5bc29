"""Shells alone: `suite.py` lists what is measured, then one file a question.

``roof.py`` (formulations, locking, rates), ``rotations.py`` (large rotations against published
tables), ``speed.py`` (kernel, linear solvers, factors that are kept). ``views.py``: the tables.
"""
