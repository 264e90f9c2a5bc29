"""Values of scenes from TOML: numbers, words, lists, inline tables and files, one by one."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from .input_file import InputFile, LocatedName
from .limits import finite, named, out_of_range, shown
from .scene_file import nearest
from .scene_text import field_names

MISSING: Any = object()  # of a value that a message was written about
_TYPES = {str: "a string", bool: "true or false", int: "a whole number", float: "a number"}


def value(path: str, raw: Any, kind: Any, errors: list[str]) -> Any:
    """``raw`` as ``kind``, or `MISSING` after a message."""
    origin = get_origin(kind)
    if origin in (Union, UnionType):
        return _one_of(path, raw, [k for k in get_args(kind) if k is not NoneType], errors)
    if origin is tuple:
        return _list(path, raw, get_args(kind), errors)
    if kind is InputFile:
        return _file(path, raw, errors)
    if is_dataclass(kind):
        return _inline(path, raw, kind, errors)
    number = kind in (int, float) and type(raw) in (int, float)
    if number and not finite(raw):
        errors.append(f"{path}: must be finite, not {shown(raw)}")
        return MISSING
    if type(raw) is not kind and not (number and kind is float):
        errors.append(f"{path}: must be {_TYPES[kind]}, not {shown(raw)}")
        return MISSING
    return kind(raw)


def _one_of(path: str, raw: Any, kinds: list[Any], errors: list[str]) -> Any:
    """A table where one is given, else the other type."""
    table: Any = next(k for k in kinds if is_dataclass(k))
    plain = next(k for k in kinds if not is_dataclass(k))
    if not isinstance(raw, dict) and plain in _TYPES and type(raw) is not plain:
        keys = ", ".join(field_names(table))
        errors.append(f"{path}: must be {_TYPES[plain]} or a table of {keys}, not {shown(raw)}")
        return MISSING
    return value(path, raw, table if isinstance(raw, dict) else plain, errors)


def _list(path: str, raw: Any, kinds: tuple[Any, ...], errors: list[str]) -> Any:
    """A list of fixed length, or of any if ``kinds`` ends with an ellipsis."""
    free = kinds[-1] is Ellipsis
    if not isinstance(raw, list) or not (free or len(raw) == len(kinds)):
        many = "" if free else f"{len(kinds)} "
        what = "tables" if is_dataclass(kinds[0]) else "strings" if kinds[0] is str else "numbers"
        errors.append(f"{path}: must be a list of {many}{what}, not {shown(raw)}")
        return MISSING
    each = [kinds[0]] * len(raw) if free else list(kinds)
    entries = [
        value(f"{path}[{i}]", *pair, errors) for i, pair in enumerate(zip(raw, each, strict=True))
    ]
    return MISSING if any(entry is MISSING for entry in entries) else tuple(entries)


def _file(path: str, raw: Any, errors: list[str]) -> Any:
    """A file that is there."""
    if not isinstance(raw, LocatedName):
        errors.append(f"{path}: must be the name of a file, not {shown(raw)}")
        return MISSING
    try:
        return InputFile.at(raw.name, raw.folder)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        errors.append(
            f"{path}: {shown(raw.name)} cannot be read from {raw.folder}: {reason}; names count "
            "from the scene's folder"
        )
        return MISSING


def _inline(path: str, raw: Any, kind: Any, errors: list[str]) -> Any:
    """An inline table."""
    if not isinstance(raw, dict):
        example = ", ".join(f"{k} = ..." for k in field_names(kind))
        errors.append(f"{path}: must be a table {{ {example} }}, not {shown(raw)}")
        return MISSING
    before = len(errors)
    good = entries(path, raw, kind, errors)
    return kind(**good) if len(errors) == before else MISSING


def entries(path: str, table: dict[str, Any], kind: Any, errors: list[str]) -> dict[str, Any]:
    """Good values of a table; a message for each other one."""
    hints, limits = get_type_hints(kind), {f.name: f for f in fields(kind)}
    good = {}
    for key, raw in table.items():
        where = f"{path}.{named(key)}"
        if key not in limits:
            errors.append(f"{where}: unknown key{nearest(key, field_names(kind))}")
            continue
        found = value(where, raw, hints[key], errors)
        if found is MISSING:
            continue
        wrong = out_of_range(where, found, limits[key].metadata)
        errors += wrong
        if not wrong:
            good[key] = found
    return good
