"""Trials of what this software promises: each one is held, broken aloud, or broken in silence.

`folders.py` tries run folders: what is lost or goes wrong when files are damaged (`damage.py`), a
disk is full, a process is killed (`struck.py`) or two of them meet.
"""
