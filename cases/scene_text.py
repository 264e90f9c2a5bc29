"""A resolved scene as TOML that reads back to an equal scene."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

from .kinds.adaptive_flow import config as flow_config
from .kinds.inflation.config import Scene
from .loader import KINDS


def write(scene: Scene | flow_config.Scene) -> str:
    """The scene as TOML with every default spelled out; reads back to an equal scene."""
    top = ("name", "description", "kind")
    lines = [f"{key} = {_literal(getattr(scene, key))}" for key in top]
    groups = scene.physical.groups() if scene.physical else {}
    for section, kind in KINDS[scene.kind].SECTIONS.items():
        part = getattr(scene, section)
        if part is None:
            continue
        lines += ["", f"[{section}]"]
        for key in _fields(kind):
            line = f"{key} = {_literal(getattr(part, key))}"
            given = f"{section}.{key}" in groups
            lines.append(f"# {line}  # from [physical]" if given else line)
    return "\n".join(lines) + "\n"


def _fields(section: type) -> dict[str, Any]:
    return {f.name: f for f in fields(section)}


def _literal(value: Any) -> str:
    """A TOML literal."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_literal(entry) for entry in value) + "]"
    if isinstance(value, int | float):
        return repr(value)
    raise TypeError(f"no TOML literal for {value!r}")
