"""Tables of README files, generated from the results that are committed in ``results``.

``python -m cases.benchmarks.tables`` rewrites what stands between ``<!-- table NAME:VIEW -->`` or
``<!-- headline -->`` and ``<!-- end -->``. What a table shows is a `View` in ``NAME/views.py``;
the view ``origin`` of every benchmark says where its results come from.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

from .headline import headline
from .view import View, results, table

HERE = Path(__file__).parent
FILES = (HERE / "README.md", HERE.parents[1] / "README.md", HERE.parent / "scenes" / "README.md")
MARKED = re.compile(
    r"(<!-- (?:table (?P<name>\w+):(?P<view>\w+)|headline) -->\n).*?(<!-- end -->)", re.DOTALL
)


def views(name: str) -> Mapping[str, View]:
    """The tables of a benchmark."""
    return import_module(f"{__package__}.{name}.views").VIEWS


def origin(name: str) -> str:
    """Where, when and from which code results come."""
    report = results(name)
    m = report["machine"]
    size = "Small sizes (`--quick`)" if report["quick"] else "Full sizes"
    return (
        f"{size}, {report['date']}, commit {report['commit']}, {m['cores']} cores of "
        f"{m['processor']}, load {m['load']:g} at the start.\n"
    )


def regenerated(text: str) -> str:
    """A README with all its tables made anew."""
    return MARKED.sub(lambda match: f"{match[1]}\n{_made(match)}\n{match[4]}", text)


def _made(match: re.Match[str]) -> str:
    name, view = match["name"], match["view"]
    if name is None:
        return headline()
    return origin(name) if view == "origin" else table(name, views(name)[view])


def main() -> None:
    """Rewrite the README files."""
    for path in FILES:
        path.write_text(regenerated(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
