"""Honesty: what the solvers promise, tried on inputs made to break it; nothing may fail in silence.

A trial is a promise, a case, the tolerance promised, the error found, and whether the program said
that it cannot: it refused the input, or its own measured error is above the tolerance. `matrices`
tries compressed operators on `clouds`, and forces under the `disguises` that must not change them.
"""
