"""A resolved scene as TOML that reads back to an equal scene."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

from .sections import AnyScene

TOP = ("name", "description", "kind")


def write(scene: AnyScene) -> str:
    """The scene as TOML with every default spelled out; reads back to an equal scene."""
    lines = [f"{key} = {literal(getattr(scene, key))}" for key in TOP]
    groups = scene.physical.groups() if scene.physical else {}
    for section in field_names(type(scene)):
        part = getattr(scene, section)
        if section in TOP or part is None:
            continue
        lines += ["", f"[{section}]"]
        for key in field_names(type(part)):
            line = f"{key} = {literal(getattr(part, key))}"
            given = f"{section}.{key}" in groups
            lines.append(f"# {line}  # from [physical]" if given else line)
    return "\n".join(lines) + "\n"


def field_names(section: type) -> list[str]:
    """Keys of a dataclass, in order."""
    return [f.name for f in fields(section)]


def literal(value: Any) -> str:
    """A TOML literal.

    Raises
    ------
    TypeError
        A value that TOML has no literal for here.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(literal(entry) for entry in value) + "]"
    if isinstance(value, int | float):
        return repr(value)
    raise TypeError(f"no TOML literal for {value!r}")
