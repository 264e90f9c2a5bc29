"""Limits of single values: fields of scenes with defaults and admissible ranges, and messages.

Every number of a scene has a range: what lies outside could only overflow, fill the memory or run
for ever. Numbers are 0 or of a size within `REACH`, so that their products and powers stay finite.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import field, fields, is_dataclass
from typing import Any

from .input_file import InputFile, LocatedName

REACH = 1e20  # largest size of a number, its inverse the smallest one
SHOWN = 60  # characters of a bad value in a message

_TESTS = {
    "above": (lambda v, x: v > x, "above"),
    "least": (lambda v, x: v >= x, "at least"),
    "below": (lambda v, x: v < x, "below"),
    "most": (lambda v, x: v <= x, "at most"),
}


def rule(default: Any, **limits: Any) -> Any:
    """Field of a section with its default and limits.

    Parameters
    ----------
    default : Any
    above, least, below, most : float, optional
        Ends of the range.
    choices : tuple, optional
        All admissible values.
    why : str, optional
        Reason of the choices, for the message.
    only : mapping of str to tuple, optional
        Other keys of the scene and their values under which this key has an effect.
    """
    return field(default=default, metadata=limits)


def out_of_range(path: str, value: Any, limits: Mapping[str, Any]) -> list[str]:
    """What is wrong with a value of the right type, one message or none."""
    choices = limits.get("choices")
    if choices is not None:
        valid = ", ".join(map(repr, choices))
        why = f": {limits['why']}" if "why" in limits else ""
        return [] if value in choices else [f"{path}: {shown(value)} is none of {valid}{why}"]
    if not isinstance(value, int | float | tuple) or isinstance(value, bool):
        return []
    rows = value if isinstance(value, tuple) else (value,)
    values = [v for row in rows for v in (row if isinstance(row, tuple) else (row,))]
    if not all(isinstance(v, int | float) for v in values):
        return []
    wrong = [
        f"{words} {limits[key]:g}"
        for key, (test, words) in _TESTS.items()
        if key in limits and not all(test(v, limits[key]) for v in values)
    ]
    if not wrong and not all(v == 0 or 1.0 / REACH <= abs(v) <= REACH for v in values):
        wrong = [f"0 or of a size between {1.0 / REACH:g} and {REACH:g}"]
    return [f"{path}: {shown(value)} must be {' and '.join(wrong)}"] if wrong else []


def finite(raw: int | float) -> bool:
    """Whether a number is one that a double can hold."""
    return abs(raw) < 2**1000 if isinstance(raw, int) else math.isfinite(raw)


def shown(raw: Any) -> str:
    """A bad value as in TOML, cut to a readable length."""
    if isinstance(raw, dict):
        return "a section"
    if isinstance(raw, int) and abs(raw) >= 10**SHOWN:
        return f"a whole number of about {round(raw.bit_length() * math.log10(2.0))} digits"
    try:
        text = literal(raw)
    except TypeError:
        text = repr(str(raw))
    except RecursionError:
        return "a deeply nested list"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def named(key: str) -> str:
    """A key as it is, or cut and quoted where it would spoil a message."""
    return key if key.isprintable() and len(key) <= SHOWN else shown(key)


def literal(value: Any) -> str:
    """A TOML literal.

    Raises
    ------
    TypeError
        A value that TOML has no literal for here.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, InputFile | LocatedName):
        return literal(value.name)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(literal(entry) for entry in value) + "]"
    if isinstance(value, int | float):
        return repr(value)
    if is_dataclass(value):  # an inline table, without what is as usual
        own = {f.name: getattr(value, f.name) for f in fields(value)}
        value = {f.name: own[f.name] for f in fields(value) if own[f.name] != f.default}
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {literal(v)}" for k, v in value.items()) + " }"
    raise TypeError(f"no TOML literal for {value!r}")
