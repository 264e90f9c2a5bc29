"""Growth with the number of folds: `suite.py` solves for the flow in ever longer accordions.

``views.py``: the tables. Coupled runs of folded bags are scenes, not benchmarks.
"""
