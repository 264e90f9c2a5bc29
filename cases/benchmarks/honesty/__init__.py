"""Attempts to break the promises: what is tried, what holds, what breaks and whether it says so.

Read `scenes.py` (scenes are accepted as given, or refused in a message) with `mutations.py`.
"""
