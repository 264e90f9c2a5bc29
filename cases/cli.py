"""The console: airfold list | check | run | resume | bench | report.

Exit codes: 0 completed; 1 the run could not go on, or the system refused (disk full, no permission,
closed pipe); 2 bad input, a folder in use or a damaged one; 130 stopped by Ctrl-C or SIGTERM, with
a checkpoint of the last accepted step. Every failure is one message. Imports are lazy: help, list
and the validation of scenes load neither numba nor scikit-fem.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from . import loader
from .kinds import KINDS
from .output.atomic import RecordError
from .output.forecast import show
from .sections import SceneError

if TYPE_CHECKING:
    from .runs.folder import Finished

COMPLETED, STUCK, BAD_INPUT, STOPPED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the ``airfold`` command; returns the exit code."""
    try:
        for stream in (sys.stdout, sys.stderr):
            if hasattr(stream, "reconfigure"):  # a console may lack letters: show their codes
                stream.reconfigure(errors="backslashreplace")
        code = _answered(_parser().parse_args(arguments))
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except OSError as error:
        _silence_if_gone()
        if not isinstance(error, BrokenPipeError):
            with suppress(OSError):
                print(f"error: {_reason(error)}", file=sys.stderr)
        return STUCK


def _answered(options: argparse.Namespace) -> int:
    """Exit code of a command; its failures are told."""
    try:
        return options.command(options)
    except SceneError as error:
        return _bad_input(error.errors)
    except (RecordError, UnicodeError) as error:
        return _bad_input([str(error)])
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return STOPPED
    except MemoryError:
        print("error: out of memory", file=sys.stderr)
        return STUCK


def _silence_if_gone() -> None:
    """Send the output of a broken console nowhere: Python would complain once more at its end."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except (OSError, ValueError):
        with suppress(OSError, ValueError), open(os.devnull, "w", encoding="utf-8") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _reason(error: OSError) -> str:
    """What the system said, and of which file."""
    where = f"{error.filename}: " if error.filename is not None else ""
    return f"{where}{error.strerror or error}"


@contextmanager
def _stoppable() -> Iterator[None]:
    """SIGTERM, and a lost terminal, stop a run as Ctrl-C does."""

    def stop(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    signals = [getattr(signal, name, None) for name in ("SIGTERM", "SIGHUP")]
    ours = [
        number
        for number in signals
        if number is not None
        and threading.current_thread() is threading.main_thread()
        and signal.getsignal(number) is signal.SIG_DFL  # not under nohup
    ]
    try:
        for number in ours:
            signal.signal(number, stop)
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="airfold",
        description="Inflates folded, flexible bags: thin shells coupled to Stokes flow.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(
        name: str, does: Callable[[argparse.Namespace], int], text: str
    ) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(command=does)
        return sub

    command("list", _list, "scenes and benchmarks, one line each")
    check = command("check", _check, "validate a scene and forecast its cost and difficulty")
    run = command("run", _run, "run a scene")
    for sub in (check, run):
        sub.add_argument("scene", metavar="SCENE", help="name of a shipped scene, or a TOML file")
        sub.add_argument(
            "--set",
            dest="overrides",
            action="append",
            default=[],
            metavar="KEY=VALUE",
            help="override one key, for example --set time.dt=8 (repeatable)",
        )
    check.add_argument(
        "--picture",
        metavar="FILE",
        type=Path,
        help="where a user's mesh is drawn (default: <scene>-check.png)",
    )
    run.add_argument("--out", metavar="DIR", help="run folder (default: runs/<scene>-<n>)")
    resume = command("resume", _resume, "continue a run from its last checkpoint")
    report = command("report", _report, "draw the pictures of a run again")
    for sub in (resume, report):
        sub.add_argument("folder", metavar="DIR", type=Path, help="run folder")
    report.add_argument("--animation", action="store_true", help="also draw animation.gif")
    report.add_argument(
        "--loads", action="store_true", help="also draw loads.png: contact and wrinkles"
    )
    report.add_argument(
        "--beside",
        metavar="DIR",
        type=Path,
        help="also draw beside.png: both runs in space and in cuts, at equal volumes",
    )
    bench = command("bench", _bench, "run a benchmark: error against time, always both")
    bench.add_argument("name", metavar="NAME", help="see airfold list")
    bench.add_argument("--quick", action="store_true", help="small sizes only")
    bench.add_argument("--json", metavar="FILE", type=Path, help="also write the rows as JSON")
    return parser


def _list(options: argparse.Namespace) -> int:
    from .benchmarks import BENCHMARKS

    scenes = loader.shipped()
    width = max(len(name) for name in [*scenes, *BENCHMARKS])
    print("scenes")
    for name, description in scenes.items():
        print(f"  {name:<{width}}  {description}")
    print("benchmarks")
    for name, entry in BENCHMARKS.items():
        print(f"  {name:<{width}}  {entry.summary}")
    if not BENCHMARKS:
        print("  (none yet)")
    return COMPLETED


def _check(options: argparse.Namespace) -> int:
    scene = loader.runnable(options.scene, options.overrides)
    found = KINDS[scene.kind].forecast(scene)
    show(scene, found)
    if found.picture is not None:
        path = options.picture or Path(f"{scene.name}-check.png")
        print(f"picture: {found.picture(path)}")
    return COMPLETED


def _run(options: argparse.Namespace) -> int:
    scene = loader.runnable(options.scene, options.overrides)
    from rich.console import Console

    from .runs.folder import FolderError, new_folder
    from .runs.start import start

    try:
        folder = new_folder(scene, options.out)
    except FolderError as error:
        return _bad_input([str(error)])
    print(f"{scene.name}: {scene.description}\nrun folder: {folder}", flush=True)
    try:
        with _stoppable():
            finished = start(scene, folder, Console())
    except FolderError as error:
        return _bad_input([str(error)])
    return _ended(finished, folder)


def _resume(options: argparse.Namespace) -> int:
    from rich.console import Console

    from .runs.folder import FolderError
    from .runs.start import resume

    try:
        with _stoppable():
            finished = resume(options.folder, Console())
    except FolderError as error:
        return _bad_input([str(error)])
    return _ended(finished, options.folder)


def _report(options: argparse.Namespace) -> int:
    from .runs.folder import FolderError
    from .runs.pictures import animate, compare, draw, draw_loads

    try:
        print(f"picture: {draw(options.folder)}")
        if options.animation:
            print(f"animation: {animate(options.folder)}")
        if options.loads:
            print(f"loads: {draw_loads(options.folder)}")
        if options.beside:
            found = compare(options.folder, options.beside)
            print("\n".join([f"beside: {found.picture}", *found.lines]))
    except FolderError as error:
        return _bad_input([str(error)])
    return COMPLETED


def _bench(options: argparse.Namespace) -> int:
    from .benchmarks import BENCHMARKS

    if options.name not in BENCHMARKS:
        valid = ", ".join(BENCHMARKS) or "none yet"
        return _bad_input([f"{options.name}: no such benchmark; valid: {valid}"])
    from .benchmarks.report import execute

    rows = execute(options.name, BENCHMARKS[options.name].module, options.quick, options.json)
    return STUCK if any(row.get("silent") for row in rows) else COMPLETED


def _ended(finished: Finished, folder: Path) -> int:
    """Last lines of a run: its result, then its picture or how to go on."""
    outcome = finished.outcome
    if outcome is None:
        saved = f"{finished.saved} is saved" if finished.saved else "before the first step"
        print(f"stopped; {saved}; continue with: airfold resume {folder}")
        return STOPPED
    if outcome.result.ok:
        print(f"completed at {outcome.where}: {outcome.summary}")
    else:
        advice = outcome.detail or outcome.result.value
        print(f"{outcome.result.name} at {outcome.where}: {advice}", file=sys.stderr)
    print(f"picture: {finished.picture}" if finished.picture else f"results: {folder}")
    return COMPLETED if outcome.result.ok else STUCK


def _bad_input(errors: Sequence[str]) -> int:
    for error in errors:
        print(f"error: {error}", file=sys.stderr)
    return BAD_INPUT


if __name__ == "__main__":
    sys.exit(main())
