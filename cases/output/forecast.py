"""What `airfold check` found: items, physical units, warnings with their remedy; and its print."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..sections import AnyScene

GIGABYTE = 2.0**30


@dataclass(frozen=True)
class Item:
    """One forecast figure."""

    name: str
    value: float | int | str
    unit: str = ""
    note: str = ""


@dataclass(frozen=True)
class Forecast:
    """What `airfold check` prints."""

    items: tuple[Item, ...]
    warnings: tuple[str, ...]
    picture: Callable[[Path], Path] | None = None  # draws what was found into a file
    notes: tuple[str, ...] = ()  # what was read and mended, one line each


def show(scene: AnyScene, forecast: Forecast) -> None:
    """Print a forecast as a table, then its warnings."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)  # [physical] is no markup
    console.print(f"{scene.name}: {scene.description}")
    for note in forecast.notes:
        console.print(f"  {note}")
    table = Table(box=None, show_header=False, pad_edge=False)
    for column in ("left", "right", "left", "left"):
        table.add_column(justify=column)
    for item in forecast.items:
        table.add_row(item.name, _number(item.value), item.unit, item.note)
    if scene.physical:
        p = scene.physical
        table.add_row("time unit", _number(p.time_unit), "s", "L sqrt(rho_s (1-nu^2)/(E h))")
        table.add_row("pressure unit", _number(p.pressure_unit), "Pa", "E h/((1-nu^2) L)")
        for key, value in p.groups().items():
            table.add_row(key, _number(value), "", "from [physical]")
    console.print(table)
    for warning in forecast.warnings:
        console.print(f"warning: {warning}")
    if not forecast.warnings:
        console.print("no warnings")


def _number(value: float | int | str) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
