"""The console, struck by a signal at the n-th time it touches a file of its run folder.

``python -m cases.benchmarks.honesty.struck SIGNAL N COMMAND...``; the last word of the command is
the folder. With N = 0 nothing strikes; the number of touches is printed at the end.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys

TOUCHES = ("open", "os.rename", "os.truncate", "os.remove", "os.mkdir")


def main() -> None:
    """Run the console; it ends the process."""
    name, at, *command = sys.argv[1:]
    touched = 0

    def touch(event: str, details: tuple) -> None:
        nonlocal touched
        if event in TOUCHES and str(details[0]).startswith(command[-1]):
            touched += 1
            if touched == int(at):
                os.kill(os.getpid(), signal.Signals[name])

    sys.addaudithook(touch)
    sys.argv[1:] = command
    try:
        runpy.run_module("cases.cli", run_name="__main__")
    finally:
        print(f"touches: {touched}")


if __name__ == "__main__":
    main()
