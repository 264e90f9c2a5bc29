"""Folded bags: runs that open them (`openings.py`), growth with the number of folds (`suite.py`).

``views.py``: the tables. Rows of long runs are made of their folders, by ``record --runs``.
"""
