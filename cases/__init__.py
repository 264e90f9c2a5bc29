"""cases: scenes, geometry, console, files, pictures; the only place where the packages meet.

Nothing is imported here: listing and checking scenes stays light.
"""
