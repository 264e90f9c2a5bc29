"""run.json: what ran where, with which tolerances, how long each phase took and how it ended.

Replaced as a whole at every checkpoint and at the end. A resumed run adds a session to the list;
sums over ``sessions`` are the totals of the run.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..kinds.inflation.config import Scene
from ..machine import machine, versions
from .atomic import replacing
from .recorder import Silent

if TYPE_CHECKING:
    from collections.abc import Iterator

    from coupling.protocols import AcceptedStep, Outcome, Rejection, Snapshot

    from ..kinds.inflation.accuracy import Accuracy

RUNNING = "running"


class RunRecord(Silent):
    """Recorder of run.json.

    Parameters
    ----------
    path : Path
    scene : Scene
    tolerances : mapping, optional
        Resolved tolerances beside those of the scene.
    accuracy : Accuracy, optional
        What the fluid's tolerance came to; its review is written at the end.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        tolerances: Mapping[str, Any] | None = None,
        accuracy: Accuracy | None = None,
    ):
        self.path, self._accuracy = path, accuracy
        self.compression: Mapping[str, Any] = {}
        self._began = time.perf_counter()
        self._phases: Counter[str] = Counter()
        self._causes: Counter[str] = Counter()
        self._notes: Counter[str] = Counter()
        old = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        self._session = {"started": datetime.now(UTC).isoformat(timespec="seconds")}
        self._record = {
            "scene": scene.name,
            "result": RUNNING,
            "versions": versions(),
            "machine": machine(),
            "tolerances": {**scene.tolerances, **(tolerances or {})},
            **({"accuracy": {"before": accuracy.before()}} if accuracy else {}),
            "skips": old.get("skips", []),
            "sessions": [*old.get("sessions", []), self._session],
        }
        if scene.physical:
            units = {
                "time_s": scene.physical.time_unit,
                "pressure_Pa": scene.physical.pressure_unit,
            }
            self._record["physical"] = {**asdict(scene.physical), **units}

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time of a block to a phase of this session."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self._phases[name] += time.perf_counter() - start

    def skip(self, what: str) -> None:
        """Note something that was left out, and why."""
        if what not in self._record["skips"]:
            self._record["skips"].append(what)

    def contraction(self, forecast: float, measured: float) -> None:
        """Note rho at the scene's dt, a priori and by power iteration at the start."""
        self._record["contraction"] = {"a priori": forecast, "measured": measured}

    def write(self) -> None:
        """Replace the file by the present state."""
        self._session["seconds"] = round(time.perf_counter() - self._began, 3)
        if self.compression:
            self._record["compression"] = dict(self.compression)
        self._session["phases"] = {name: round(s, 3) for name, s in self._phases.items()}
        with replacing(self.path) as file:
            json.dump(self._record, file, indent=2, default=_plain)
            file.write("\n")

    def on_accepted(self, step: AcceptedStep) -> None:
        self._session.update(step=step.step, t=step.state.t)
        if self._accuracy:
            self._accuracy.note(step)

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
        if self._accuracy:
            self._record["accuracy"]["after"] = self._accuracy.after()
        self._record.update(
            result=outcome.result.name.lower(),
            advice=outcome.detail,
            step=outcome.step,
            **figures,
        )
        self.write()


def _plain(value: Any) -> Any:
    """JSON for numpy scalars and arrays."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
