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


def differences(first: AnyScene, second: AnyScene) -> list[str]:
    """Keys in which two scenes of one kind differ, ``section.key``; [output] has no effect."""
    found = [key for key in ("kind",) if getattr(first, key) != getattr(second, key)]
    for section in field_names(type(first)):
        if section in TOP or section == "output":
            continue
        a, b = getattr(first, section), getattr(second, section, None)
        if type(a) is not type(b):
            found.append(section)
        elif a is not None:
            keys = field_names(type(a))
            found += [f"{section}.{k}" for k in keys if getattr(a, k) != getattr(b, k)]
    return found
