"""A resolved scene as TOML that reads back to an equal scene."""

from __future__ import annotations

from dataclasses import fields

from .limits import literal
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
