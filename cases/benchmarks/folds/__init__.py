"""Folded bags: runs that open them (`openings`, `opened`, `like`), many folds (`ladder`).

``views.py``: the tables. Rows of long runs are made of their folders, by ``record --runs``.
"""
