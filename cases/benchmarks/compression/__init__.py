"""Compressed operators: `suite.py` on clouds of points, then ``bags.py`` on surfaces.

``bags.py`` has the storage of full operators and whole fluid solves, each in a process of its own.
``views.py``: the tables.
"""
