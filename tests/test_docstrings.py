"""Every public name says what it takes, gives and raises, in numpydoc's sections."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
STUBS = [p for k in ("shells", "hbem", "coupling", "cases") for p in (ROOT / k).rglob("*.pyi")]
NAMES = sorted(
    f"{'.'.join(stub.parent.relative_to(ROOT).parts)}:{name}"
    for stub in STUBS
    for name in re.findall(r" as (\w+)$", stub.read_text(encoding="utf-8"), re.MULTILINE)
)


def _sections(thing: Any) -> dict[str, str]:
    """Text of a docstring's sections by title; what stands before them under ''."""
    lines = (inspect.getdoc(thing) or "").split("\n")
    found, title = {"": ""}, ""
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if line and below == "-" * len(line):
            title = line
            found[title] = ""
        else:
            found[title] += line + "\n"
    return found


def _documented(text: str) -> set[str]:
    """Names in front of a colon, or alone, at the margin of a section."""
    heads = re.findall(r"^([*\w][\w*, ]*?)(?: :.*)?$", text, re.MULTILINE)
    return {name.strip().lstrip("*") for head in heads for name in head.split(",")}


def _raised(function: Any) -> set[str]:
    """Exceptions that a function raises itself."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    raised = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc]
    calls = [e.func if isinstance(e, ast.Call) else e for e in raised]
    return {c.id for c in calls if isinstance(c, ast.Name) and c.id[0].isupper()}


def _missing(name: str, thing: Any, *, parameters: bool = True) -> list[str]:
    """What the docstring of a function or a class leaves out."""
    sections, wrong = _sections(thing), []
    if not sections[""].strip():
        return [f"{name}: no docstring"]
    known = _documented(sections.get("Parameters", "") + sections.get("Attributes", ""))
    taken = [p for p in inspect.signature(thing).parameters if p not in ("self", "cls")]
    if parameters:
        wrong += [f"{name}: parameter {p}" for p in taken if p.lstrip("_") not in known]
    if not inspect.isclass(thing):
        returns = inspect.signature(thing).return_annotation
        gives = returns not in (None, "None", inspect.Signature.empty)
        if parameters and gives and not {"Returns", "Yields"} & sections.keys():
            wrong.append(f"{name}: Returns")
        listed = _documented(sections.get("Raises", ""))
        wrong += [f"{name}: Raises {e}" for e in _raised(thing) if e not in listed]
    return wrong


@pytest.mark.parametrize("name", NAMES)
def test_public_names_are_documented(name: str) -> None:
    package, _, attribute = name.partition(":")
    thing = getattr(importlib.import_module(package), attribute)
    if not callable(thing) or (inspect.isclass(thing) and issubclass(thing, Exception)):
        assert inspect.getdoc(thing)
        return
    # members of an enumeration explain themselves, a Protocol is not made by calling it
    made = not (hasattr(thing, "__members__") or getattr(thing, "_is_protocol", False))
    wrong = _missing(attribute, thing, parameters=made)
    if inspect.isclass(thing):
        for method, function in vars(thing).items():
            public = not method.startswith("_") and getattr(function, "__name__", "") == method
            if inspect.isfunction(function) and public:
                wrong += _missing(f"{attribute}.{method}", getattr(thing, method), parameters=False)
    assert wrong == []
