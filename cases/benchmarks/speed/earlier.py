"""The revision that speeds are compared with, and probes run under it and under this one."""

from __future__ import annotations

import getpass
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from ...machine import THREADS

REVISION = "7d93046"  # the last one before kernels, start and coupled steps were made faster
HERE = Path(__file__).parent
ROOT = HERE.parents[2]
SECONDS = 3600.0  # after which a probe has failed

Figures = Mapping[str, Any]


class NoProbe(Exception):
    """A probe that ended without figures."""


@cache
def tree() -> Path | None:
    """Folder of the earlier revision, its kernels' cache kept between runs; None without git."""
    place = Path(tempfile.gettempdir()) / f"airfold-{REVISION}-{getpass.getuser()}"
    if not (place / "cases" / "cli.py").exists():
        place.mkdir(mode=0o700, exist_ok=True)
        archive = ["git", "-C", str(ROOT), "archive", REVISION]
        try:
            packed = subprocess.run(archive, capture_output=True, check=True).stdout
            subprocess.run(["tar", "-x", "-C", str(place)], input=packed, check=True)
        except (OSError, subprocess.CalledProcessError):
            return None
    return place


def figures(probe: str, root: Path, function: str, *arguments: Any, threads: int = 0) -> Figures:
    """What a function of a probe finds under the tree at ``root``; nested names are joined.

    Raises
    ------
    NoProbe
        With the end of what it printed.
    """
    call = f"runpy.run_path({str(HERE / probe)!r} + '.py')[{function!r}](*{arguments!r})"
    command = [sys.executable, "-P", "-c", f"import json, runpy; print(json.dumps({call}))"]
    environment = os.environ | {"PYTHONPATH": str(root)}
    if threads:
        environment |= dict.fromkeys(THREADS, str(threads))
    run = subprocess.run(
        command, capture_output=True, text=True, env=environment, cwd=root, timeout=SECONDS
    )
    if run.returncode:
        raise NoProbe(f"{probe} under {root}: {run.stderr[-500:]}")
    return dict(_flat(json.loads(run.stdout.splitlines()[-1])))


def _flat(found: Figures, name: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in found.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{name}{key}, ")
        else:
            yield name + key, value
