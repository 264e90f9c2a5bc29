"""run.json: what ran where, with which tolerances, how long each phase took and how it ended.

Replaced as a whole at every checkpoint and at the end. A resumed run adds a session to the list;
sums over ``sessions`` are the totals of the run.
"""

from __future__ import annotations

import json
import logging
import time
from collections import Counter, defaultdict
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..machine import machine, versions
from ..sections import AnyScene, Physical
from .atomic import RecordError, replacing
from .recorder import Silent

if TYPE_CHECKING:
    from collections.abc import Iterator

    from coupling import AcceptedStep, Outcome, Rejection, Snapshot

    from .accuracy import Accuracy

logger = logging.getLogger(__name__)
RUNNING = "running"


class RunRecord(Silent):
    """Recorder of run.json.

    Parameters
    ----------
    path : Path
    scene : Scene
    tolerances : mapping, optional
        Resolved tolerances beside those of the scene.

    Raises
    ------
    RecordError
        A damaged record of earlier sessions.
    """

    def __init__(
        self,
        path: Path,
        scene: AnyScene,
        tolerances: Mapping[str, Any] | None = None,
    ):
        self.path = path
        self._accuracy: Accuracy | None = None
        self.compression: Mapping[str, Any] = {}
        self._began = time.perf_counter()
        self._phases: defaultdict[str, float] = defaultdict(float)
        self._causes: Counter[str] = Counter()
        self._notes: Counter[str] = Counter()
        old = _earlier(path)
        before = old.get("accuracy")
        achieved = before.get("after") if isinstance(before, dict) else None
        self._achieved: Mapping[str, Any] = achieved if isinstance(achieved, dict) else {}
        self._session: dict[str, Any] = {"started": datetime.now(UTC).isoformat(timespec="seconds")}
        self._record: dict[str, Any] = {
            "scene": scene.name,
            "result": RUNNING,
            "versions": versions(),
            "machine": machine(),
            "tolerances": {**scene.tolerances, **(tolerances or {})},
            "skips": old.get("skips", []),
            "sessions": [*old.get("sessions", []), self._session],
        }
        if scene.physical:
            self._record["physical"] = _units(scene.physical)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time of a block to a phase of this session."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self._phases[name] += time.perf_counter() - start

    def expect(self, accuracy: Accuracy) -> None:
        """Note what the fluid's tolerance came to; what the run achieves is kept up to date."""
        self._accuracy = accuracy
        if self._achieved:
            accuracy.taken_up(self._achieved)
        self._record["accuracy"] = {"before": accuracy.before()}

    def skip(self, what: str) -> None:
        """Note something that was left out, and why."""
        if what not in self._record["skips"]:
            self._record["skips"].append(what)

    def contraction(self, forecast: float, measured: float) -> None:
        """Note rho at the scene's dt, a priori and by power iteration at the start."""
        self._record["contraction"] = {"a priori": forecast, "measured": measured}

    @contextmanager
    def kept_on_failure(self) -> Iterator[None]:
        """Note an interrupt or an error that ends a block, and pass it on.

        A refused folder stays as it is.
        """
        try:
            yield
        except RecordError:
            raise
        except (KeyboardInterrupt, Exception) as error:
            why = f"failed: {type(error).__name__}: {error}"
            with suppress(OSError):  # what ended the run is the one thing to tell
                self.broken_off("interrupted" if isinstance(error, KeyboardInterrupt) else why)
            raise

    def write(self) -> None:
        """Replace the file by the present state."""
        self._session["seconds"] = round(time.perf_counter() - self._began, 3)
        if self.compression:
            self._record["compression"] = dict(self.compression)
        if self._accuracy:
            self._record["accuracy"]["after"] = self._accuracy.after()
        self._session["phases"] = {name: round(s, 3) for name, s in self._phases.items()}
        with replacing(self.path) as file:
            json.dump(self._record, file, indent=2, default=_plain)
            file.write("\n")

    def on_accepted(self, step: AcceptedStep) -> None:
        self._session.update(step=step.step, t=step.state.t)
        if self._accuracy:
            said = self._accuracy.note(step)
            if said:
                self.on_note(step.step, said)
                logger.info("step %d: %s", step.step, said)

    def on_rejected(self, rejection: Rejection) -> None:
        self._causes[rejection.cause.name] += 1
        self._session["rejections"] = dict(self._causes)

    def on_note(self, step: int, text: str) -> None:
        self._notes[text.split(":")[0].split(" = ")[0]] += 1
        self._session["notes"] = dict(self._notes)

    def on_checkpoint(self, snapshot: Snapshot) -> None:
        self._session.update(step=snapshot.step, t=snapshot.state.t)
        self.write()

    def broken_off(self, result: str) -> None:
        """Note an end that the time loop did not decide."""
        self._record["result"] = result
        self.write()

    def close(self, outcome: Outcome) -> None:
        self.ended(outcome, t=outcome.t)

    def ended(self, outcome: Any, **figures: float) -> None:
        """Note how a run of any kind ended."""
        self._session["counts"] = dict(outcome.counts)
        self._record.update(
            result=outcome.result.name.lower(),
            advice=outcome.detail,
            step=outcome.step,
            **figures,
        )
        self.write()


def _earlier(path: Path) -> Mapping[str, Any]:
    """What earlier sessions left in run.json; empty if there are none."""
    try:
        old = json.loads(path.read_text(encoding="utf-8"))
        skips, sessions = old["skips"], old["sessions"]
        good = isinstance(skips, list) and all(isinstance(skip, str) for skip in skips)
        good &= isinstance(sessions, list) and all(isinstance(s, dict) for s in sessions)
    except FileNotFoundError:
        return {}
    except (ValueError, LookupError, TypeError, RecursionError):
        good = False
    if not good:
        raise RecordError(
            f"{path.name} is damaged; put it back, or remove it to go on without the record of "
            "earlier sessions"
        )
    return old


def _units(physical: Physical) -> dict[str, float]:
    units = {"time_s": physical.time_unit, "pressure_Pa": physical.pressure_unit}
    return {**asdict(physical), **units}


def _plain(value: Any) -> Any:
    """JSON for numpy scalars and arrays."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
