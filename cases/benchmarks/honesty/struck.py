"""The console, struck by a signal at the n-th time it touches a file of its run folder.

``python -m cases.benchmarks.honesty.struck SIGNAL N COMMAND...``; the last word of the command is
the folder. With N = 0 nothing strikes, and the number of touches is printed.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from ... import cli

TOUCHES = ("open", "os.rename", "os.truncate", "os.remove", "os.mkdir")


def main(words: Sequence[str]) -> int:
    """Exit code of the console, if it lives to give one."""
    number, at, *command = words
    touched = 0

    def touch(event: str, details: tuple) -> None:
        nonlocal touched
        if event in TOUCHES and str(details[0]).startswith(command[-1]):
            touched += 1
            if touched == int(at):
                os.kill(os.getpid(), signal.Signals[number])

    sys.addaudithook(touch)
    code = cli.main(command)
    print(f"touches: {touched}")
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
