"""history.csv: one row an accepted step, 17 significant digits, wall time in the last column.

The header is made of the first row's keys. With a [physical] table the most wanted columns follow
a second time in SI units (suffix ``_si``).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..sections import Physical
from .atomic import RecordError
from .recorder import Silent

if TYPE_CHECKING:
    from coupling import AcceptedStep

LAST = "wall_time"


class History(Silent):
    """Recorder of history.csv.

    Parameters
    ----------
    path : Path
    physical : Physical, optional
        Adds columns in s, m^3, m^2 and Pa.
    """

    def __init__(self, path: Path, physical: Physical | None = None):
        self.path = path
        self._units = _units(physical) if physical else {}
        self._columns: list[str] = []

    def on_start(self, step: AcceptedStep) -> None:
        self.append(step.row)

    def on_accepted(self, step: AcceptedStep) -> None:
        self.append(step.row)

    def append(self, row: Mapping[str, float]) -> None:
        """Add one row; the first one makes the header.

        Raises
        ------
        RecordError
            The file has other columns than the row.
        """
        physical = {f"{k}_si": row[k] * unit for k, unit in self._units.items() if k in row}
        full = {**row, **physical}
        if LAST in full:
            full[LAST] = full.pop(LAST)
        text = ",".join(_digits(value) for value in full.values()) + "\n"
        if not self.path.exists():
            text = ",".join(full) + "\n" + text
            self._columns = list(full)
        self._columns = self._columns or _header(self.path)
        if self._columns != list(full):
            raise RecordError(f"{self.path.name} has other columns than this version writes")
        # one write of whole lines: a killed run leaves no torn rows behind
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(text)


def read_history(path: Path) -> dict[str, np.ndarray]:
    """Columns of a history.csv by name.

    Raises
    ------
    RecordError
        A damaged file; a last line without end is none, it is being written.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        header, *rows = list(csv.reader(line for line in lines if line.endswith("\n")))
        values = np.array(rows, dtype=float).reshape(-1, len(header))
    except (ValueError, csv.Error) as error:
        raise RecordError(f"{path} is damaged: {error}") from error
    return {name: values[:, i] for i, name in enumerate(header)}


def _header(path: Path) -> list[str]:
    with open(path, encoding="utf-8") as file:
        return file.readline().rstrip("\n").split(",")


def _units(physical: Physical) -> dict[str, float]:
    length = physical.length
    return {
        "t": physical.time_unit,
        "volume": length**3,
        "area": length**2,
        "pressure": physical.pressure_unit,
        "min_gap": length,
    }


def _digits(value: float) -> str:
    return str(value) if isinstance(value, int | np.integer) else f"{value:.17g}"
