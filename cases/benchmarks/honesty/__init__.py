"""Trials of what this software promises: each one is held, broken aloud, or broken in silence.

`matrices` tries compressed operators on `clouds` and forces under the `disguises` that must not
change them, `flows` the measured errors of tractions, `shells` five kinds of shells, `scenes`
damaged and extreme scenes (`mutations`), `folders` run folders: what is lost when files are damaged
(`damage`), a disk is full, a process is killed (`struck`) or two of them meet.
"""
