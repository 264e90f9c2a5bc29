"""Trials of what this software promises: each is held, broken aloud, or broken in silence.

`shells.py` tries shells over degrees, knots, cuts and loads beyond what they carry.
"""
