"""Scenes from TOML: strict, all problems at once, with the nearest valid name.

``read`` takes a shipped scene's name or a path, applies ``--set`` overrides and validates; the
scene's key ``kind`` tells which tables it may have.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

from .input_file import InputFile, LocatedName
from .kinds import KINDS
from .kinds.kind import Kind
from .limits import named, out_of_range, shown
from .scene_file import home_of, last_resort, names, nearest, parse, text_of
from .scene_text import field_names
from .sections import DETERMINED, AnyScene, Choice, Physical, SceneError
from .values import MISSING, entries, value

_TOP = {"name": str, "description": str}
_LONGEST = {"name": 100, "description": 1000}
_WORDS = {
    "kind",
    *(s.key for kind in KINDS.values() for s in kind.sections.values() if isinstance(s, Choice)),
}


def shipped() -> dict[str, str]:
    """Names and descriptions of the scenes that come with the package."""
    return {name: parse(name, text_of(name))["description"] for name in names()}


def read(scene: str | Path, overrides: Sequence[str] = ()) -> AnyScene:
    """Load and validate a scene; its key ``kind`` tells which simulation it is.

    Parameters
    ----------
    scene : str or Path
        Name of a shipped scene, or a path to a TOML file.
    overrides : sequence of str
        ``"section.key=value"`` with TOML values; bare strings need no quotes.

    Raises
    ------
    SceneError
        With all problems at once.
    """
    with last_resort(str(scene), text := text_of(scene)):
        return _read(scene, text, overrides)


def _read(scene: str | Path, text: str, overrides: Sequence[str]) -> AnyScene:
    table = parse(str(scene), text)
    _locate(table, home_of(scene))
    # words that choose tables first: these take the other overrides, in whatever order given
    ordered = sorted(overrides, key=lambda item: item.partition("=")[0].strip() not in _WORDS)
    errors = [message for item in ordered for message in _override(table, item)]
    _locate(table, Path.cwd())  # names on the command line count from here
    table.setdefault("name", Path(scene).stem)
    return _scene(table, errors)


def runnable(scene: str | Path, overrides: Sequence[str] = ()) -> AnyScene:
    """As `read`, and small enough for this machine, by estimates that build nothing.

    Raises
    ------
    SceneError
        With all problems at once, or what the scene would need.
    """
    found = read(scene, overrides)
    with last_resort(found.name, found):
        KINDS[found.kind].sizes(found).check()
    return found


def _locate(table: dict[str, Any], folder: Path) -> None:
    """Say of names of files which folder they count from, where that is not known yet."""
    for section, keys in _file_keys().items():
        part = table.get(section)
        if not isinstance(part, dict):
            continue
        for key in keys:
            if isinstance(part.get(key), str):
                part[key] = LocatedName(part[key], folder)


@cache
def _file_keys() -> dict[str, set[str]]:
    """Keys of each section, of any kind and shape, that name files."""
    found: dict[str, set[str]] = {}
    for kind in KINDS.values():
        for name, section in kind.sections.items():
            for table in section.tables.values() if isinstance(section, Choice) else (section,):
                keys = {k for k, hint in get_type_hints(table).items() if hint is InputFile}
                found.setdefault(name, set()).update(keys)
    return found


def _override(table: dict[str, Any], item: str) -> list[str]:
    """Put one ``path=value`` into the table; messages if it cannot be."""
    path, equals, text = item.partition("=")
    path, text = path.strip(), text.strip()
    if not equals or not path:
        return [f"--set {shown(item)}: expected section.key=value"]
    try:
        item.encode()
        given = tomllib.loads(f"value = {text}")
        value = given["value"] if len(given) == 1 else text  # no second key behind a line's end
    except UnicodeEncodeError:
        return [f"--set {shown(ascii(item))}: is not UTF-8 text"]
    except tomllib.TOMLDecodeError:
        value = text
    except ValueError:
        return [f"--set {shown(path)}: the number has too many digits"]
    _drop_other_words(table, path, value)
    *parents, key = path.split(".")
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            return [f"--set {shown(item)}: {named(parent)} is a value, not a section"]
    table[key] = value
    return []


def _drop_other_words(table: dict[str, Any], path: str, value: Any) -> None:
    """Another shape on the command line takes the place of the file's with all of its keys."""
    kind = table.get("kind", next(iter(KINDS)))
    sections = KINDS[kind].sections if isinstance(kind, str) and kind in KINDS else {}
    for name, choice in sections.items():
        if not isinstance(choice, Choice) or choice.key != path or not isinstance(value, str):
            continue
        word = _word(table, choice)
        old = choice.tables.get(word) if isinstance(word, str) else None
        if old is not choice.tables.get(value):
            table[name] = {}


def _word(table: Mapping[str, Any], choice: Choice) -> Any:
    """The word of a table that chooses among the shapes of a section."""
    section, key = choice.key.split(".")
    part = table.get(section, {})
    return part.get(key, choice.default) if isinstance(part, dict) else choice.default


def _scene(table: Mapping[str, Any], errors: list[str]) -> AnyScene:
    """Scene of a parsed table; all problems are collected before any is raised."""
    kind = _kind(table, errors)
    known = [*_TOP, "kind", *kind.sections]
    for key in table:
        if key not in known:
            errors.append(f"{named(key)}: unknown key{nearest(key, known)}")
    values = {key: value(key, table.get(key, ""), type_, errors) for key, type_ in _TOP.items()}
    values = {key: "" if found is MISSING else found for key, found in values.items()}
    errors += [m for key in _TOP for m in _unreadable(key, values[key], errors)]
    sections = {
        name: _section(name, section, table, errors)
        for name, section in kind.sections.items()
        if name in table or isinstance(section, Choice)
    }
    scene = kind.scene(**values, **sections)
    if scene.physical is not None:
        errors += _given_twice(table)
        errors += _absent(table["physical"])
    if errors:
        # combinations are judged where each value is good by itself
        bad = {message.split(":")[0].split(".")[0] for message in errors}
        errors += [m for m in kind.impossible(scene) if m.split(".")[0] not in bad]
        raise SceneError(errors)
    if physical := scene.physical:
        scene = _with_groups(scene, physical)
        if wrong := _groups_out_of_range(scene, physical):
            raise SceneError(wrong)
    if wrong := kind.impossible(scene):
        raise SceneError(wrong)
    return scene


def _unreadable(key: str, text: str, errors: Sequence[str]) -> list[str]:
    """What is wrong with a text: names become folders, both are printed on one line."""
    if any(message.startswith(f"{key}:") for message in errors):
        return []
    bad = text in ("", ".", "..") or not text.isprintable() or {"/", "\\"} & {*text}
    if key == "name" and bad:
        return [f"name: {shown(text)} names no folder; use printable characters without slashes"]
    most = _LONGEST[key]
    return [f"{key}: has {len(text)} characters; use {most} at most"] if len(text) > most else []


def _kind(table: Mapping[str, Any], errors: list[str]) -> Kind:
    first = next(iter(KINDS.values()))
    name = table.get("kind", first.name)
    if isinstance(name, str) and name in KINDS:
        return KINDS[name]
    errors.append(f"kind: {shown(name)} is none of {', '.join(map(repr, KINDS))}")
    return first


def _section(name: str, section: type | Choice, scene: Mapping[str, Any], errors: list[str]) -> Any:
    """One section; its bad values are reported and replaced by defaults."""
    choice, table = section if isinstance(section, Choice) else None, scene.get(name, {})
    table_type = _chosen(name, section, scene, errors) if isinstance(section, Choice) else section
    if not isinstance(table, dict):
        errors.append(f"{name}: must be a section [{name}], not {shown(table)}")
        return table_type()
    good, known = {}, field_names(table_type)
    for key, raw in table.items():
        path = f"{name}.{named(key)}"
        if choice is not None and path == choice.key:
            continue
        if key not in known:
            errors.append(f"{path}: {_unknown(key, table_type, choice, scene)}")
            continue
        good[key] = raw
    return table_type(**entries(name, good, table_type, errors))


def _chosen(name: str, choice: Choice, scene: Mapping[str, Any], errors: list[str]) -> type:
    """The table that the scene's word chooses; the first one after a message."""
    word = _word(scene, choice)
    if isinstance(word, str) and word in choice.tables:
        return choice.tables[word]
    if choice.key.startswith(f"{name}."):  # said once, where the word stands
        valid = ", ".join(map(repr, choice.tables))
        errors.append(f"{choice.key}: {shown(word)} is none of {valid}")
    return choice.tables[choice.default]


def _unknown(key: str, table: type, choice: Choice | None, scene: Mapping[str, Any]) -> str:
    """Why a section has no such key: it belongs to another shape, or to none."""
    owners = choice.owners(key) if choice is not None else []
    if choice is not None and owners:
        valid = " or ".join(map(repr, owners))
        return f"belongs to {choice.key} = {valid}, not to {shown(_word(scene, choice))}"
    return f"unknown key{nearest(key, field_names(table))}"


def _given_twice(table: Mapping[str, Any]) -> list[str]:
    """Dimensionless keys beside a [physical] table that determines them."""
    sections = {name: part for name, part in table.items() if isinstance(part, dict)}
    return [
        f"{key}: follows from {physical}; give one of the two"
        for key, physical in DETERMINED.items()
        if key.split(".")[1] in sections.get(key.split(".")[0], {})
    ]


def _absent(physical: Any) -> list[str]:
    """Values of [physical] that are needed but not given."""
    needed = [key for key in field_names(Physical) if key != "poisson_ratio"]
    given = physical if isinstance(physical, dict) else {}
    return [f"physical.{key}: is needed in [physical]" for key in needed if key not in given]


def _with_groups(scene: Any, physical: Physical) -> AnyScene:
    """Scene whose dimensionless groups follow from its [physical] table."""
    for path, number in physical.groups().items():
        section, key = path.split(".")
        scene = replace(scene, **{section: replace(getattr(scene, section), **{key: number})})
    return scene


def _groups_out_of_range(scene: Any, physical: Physical) -> list[str]:
    """Dimensionless groups that SI values push beyond their limits."""
    found = []
    for path in physical.groups():
        section, key = path.split(".")
        part = getattr(scene, section)
        limits = {f.name: f.metadata for f in fields(part)}[key]
        for message in out_of_range(path, getattr(part, key), limits):
            found.append(f"{message}; it follows from {DETERMINED[path]}")
    return found
