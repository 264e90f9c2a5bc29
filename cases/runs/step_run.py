"""A run without the time loop: its kind takes the steps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..kinds.kind import StepKind
from ..output.run_record import RunRecord
from ..output.step_records import StepRecords
from ..sections import AnyScene
from .folder import Finished
from .pictures import draw_at_end

if TYPE_CHECKING:
    from rich.console import Console


def run_steps(
    kind: StepKind,
    scene: AnyScene,
    folder: Path,
    console: Console,
    tolerances: Mapping[str, Any] | None = None,
    *,
    resume: bool,
) -> Finished:
    """Take the steps of a scene and record them in a folder.

    Raises
    ------
    RecordError
        A checkpoint of another scene, or a damaged folder.
    """
    record = RunRecord(folder / "run.json", scene, tolerances)
    records = StepRecords(folder, scene, console, record, resume)
    try:
        with record.kept_on_failure():
            if not records.start:
                record.write()
            outcome = kind.run(scene, records)
            record.ended(outcome)
            return Finished(outcome, draw_at_end(scene, folder, record, console))
    except KeyboardInterrupt:
        return Finished(None, saved="its last whole step")
