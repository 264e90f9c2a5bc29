"""Runs and their folders.

Read `start.py` (start a run, resume it), `time_run.py` and `step_run.py` (the two runners, for
kinds with and without time), `folder.py`, `lock.py` (one writer a folder), `progress.py` (news on
the console), `pictures.py` (draw a folder again).
"""
