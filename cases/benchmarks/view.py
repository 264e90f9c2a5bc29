"""What a table shows of a benchmark's committed results, and the table as Markdown.

Templates are texts with fields of a row in braces, ``"{error:.1e}"``.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"
NONE = "-"


@dataclass(frozen=True)
class View:
    """Rows and columns of a benchmark that make one table.

    Attributes
    ----------
    case : str
        Regular expression for the whole case of a row; its named groups are fields of the row.
    columns : mapping of str to str
        Title to template, for example ``{"error": "{error:.1e}"}``.
    across : tuple of two str, optional
        Templates of a title and of a cell: rows that agree in ``columns`` share one line, with a
        column for each title.
    only : mapping
        Values that fields of a row must have.
    """

    case: str
    columns: Mapping[str, str]
    across: tuple[str, str] | None = None
    only: Mapping[str, Any] = field(default_factory=dict)


@cache
def results(name: str) -> dict[str, Any]:
    """The committed report of a benchmark."""
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def rows_of(name: str, case: str, only: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Rows whose case fits, with its named groups as fields.

    Raises
    ------
    LookupError
        If there is none.
    """
    found = []
    for row in results(name)["rows"]:
        match = re.fullmatch(case, row["case"])
        if match and all(row.get(key) == value for key, value in (only or {}).items()):
            found.append({**match.groupdict(), **row})
    if not found:
        raise LookupError(f"{name}: no row fits {case!r}, {only}")
    return found


def filled(template: str, row: Mapping[str, Any]) -> str:
    """A template with the fields of a row; what is missing or not finite is a dash."""
    return re.sub(r"\{([^{}:]+):?([^{}]*)\}", lambda m: _shown(row.get(m[1]), m[2]), template)


def _shown(value: Any, form: str) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return NONE
    if isinstance(value, str):
        return value or NONE
    form = form or ("d" if isinstance(value, int) else ".3g")
    text = format(value, form)
    if form.endswith("g") and "e" in text and 1.0 <= abs(value) < 1e6:
        return f"{value:.0f}"
    # 1.4e-04 reads 1.4e-4, 1.4e+00 reads 1.4
    return re.sub(r"e([+-])0*(\d*)", lambda m: f"e{m[1].strip('+')}{m[2]}" if m[2] else "", text)


def table(name: str, view: View) -> str:
    """Markdown of one view."""
    try:
        rows = rows_of(name, view.case, view.only)
    except LookupError:
        if results(name)["quick"]:
            return "Only with full sizes.\n"
        raise
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        line = lines.setdefault(tuple(filled(t, row) for t in view.columns.values()), {})
        if view.across is not None:
            title, cell = view.across
            failed = row.get("expected") == "fail"
            line[filled(title, row)] = "fails" if failed else filled(cell, row)
    titles = list(dict.fromkeys(title for line in lines.values() for title in line))
    body = ([*lead, *(line.get(title, NONE) for title in titles)] for lead, line in lines.items())
    return markdown([*view.columns, *titles], body)


def markdown(titles: Sequence[str], body: Iterable[Sequence[str]]) -> str:
    lines = [titles, ["---"] * len(titles), *body]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
