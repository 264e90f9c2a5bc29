"""Trials of what this software promises: each one is held, broken aloud, or broken in silence.

`matrices` tries compressed operators on `clouds` and forces under the `disguises` that must not
change them, `flows` what a traction says of its own error. `folders` tries run folders: what is
lost or goes wrong when files are damaged (`damage`), a disk is full, a process is killed (`struck`)
or two of them meet. `suite` counts.
"""
