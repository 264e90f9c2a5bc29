"""Scenes are taken as they are given, or refused in a message: nothing is silently ignored.

Every trial does what `airfold check` does: it reads a file, estimates its size, forecasts it. A
trial breaks the promise by a traceback, by an answer that takes more than `LIMIT` seconds, by
refusing a valid scene; silently, by accepting nonsense or a key that does not take effect.
"""

from __future__ import annotations

import math
import tempfile
import time
import tomllib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from ... import loader
from ...input_file import InputFile
from ...kinds import KINDS
from ...kinds.kind import TimeKind
from ...output.forecast import Forecast
from ...scene_text import write
from ...sections import AnyScene, SceneError
from . import mutations
from .mutations import Damaged

LIMIT = 5.0  # seconds of the processor an answer may take
SIZE = 1e15  # numbers beyond it, or below its inverse, make no sense in any unit here
MESSAGE = 2000  # characters of a readable refusal, all its problems together
BUILT = 600  # elements of scenes that are built
Trial = dict[str, Any]


def trials(quick: bool) -> list[Trial]:
    """All trials with their outcome.

    Parameters
    ----------
    quick : bool
        Some 500 of the small scenes instead of 9000 mutations and 600 extreme values of all.

    Returns
    -------
    list of dict
        ``promise``, ``case``, ``held``, ``silent`` (broken without a word), ``detail``.
    """
    changes, extreme = (240, 80) if quick else (9000, 600)
    scenes = mutations.shipped_scenes(quick)
    checker = Checker()
    groups: dict[str, Iterator[Damaged]] = {
        "mutated scenes": mutations.mutated(changes, 7, scenes),
        "extreme values": mutations.extremes(extreme, 8),
        "raw files": mutations.raw(9),
        "minimal scenes": mutations.minimal(),
        "overrides": mutations.overridden(),
    }
    if not quick:
        groups["ends of ranges"] = mutations.ends()
    return [
        {"promise": promise, **checker.trial(damaged)}
        for promise, damaged in chain.from_iterable(
            ((name, damaged) for damaged in group) for name, group in groups.items()
        )
    ]


class Checker:
    """Reads and forecasts scenes as `airfold check` does; equal scenes once."""

    def __init__(self) -> None:
        self._known: dict[str, Forecast] = {}

    def trial(self, damaged: Damaged) -> Trial:
        """The outcome of one damaged scene."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.toml"
            path.write_bytes(damaged.data)
            began, seconds = time.process_time(), 0.0
            broken, silent = "", False
            try:
                scene = loader.runnable(path, damaged.overrides)
                forecast = self.forecast(scene)
                seconds = time.process_time() - began
                if damaged.wanted == "build":
                    _build(scene)
            except SceneError as error:
                broken = _bad_refusal(damaged, str(error))
            except Exception as error:
                broken = f"{type(error).__name__}: {error}"
            else:
                broken = self._silently_wrong(damaged, scene, forecast, path)
                silent = bool(broken)
            seconds = seconds or time.process_time() - began
        if not broken and seconds > LIMIT:
            broken = f"answered after {seconds:.1f} s"
        return {"case": damaged.case, "held": not broken, "silent": silent, "detail": broken[:300]}

    def forecast(self, scene: AnyScene) -> Forecast:
        """The forecast of a scene, from memory where an equal one was asked for."""
        text = write(scene).split("\nkind", 1)[1]
        if text not in self._known:
            self._known[text] = KINDS[scene.kind].forecast(scene)
        return self._known[text]

    def _silently_wrong(
        self, damaged: Damaged, scene: AnyScene, forecast: Forecast, path: Path
    ) -> str:
        """Why an accepted scene should not have been, or is not what the file says."""
        if damaged.wanted == "refuse":
            return "accepted"
        given = tomllib.loads(damaged.data.decode("utf-8-sig"))
        given = {} if damaged.overrides else given
        if ignored := [key for key, value in _leaves(given) if not _taken(scene, key, value)]:
            return f"ignored: {', '.join(ignored)}"
        if odd := [key for key, value in _numbers(scene) if not _sensible(value)]:
            return f"accepted: {', '.join(odd)}"
        if odd := [
            i.name for i in forecast.items if isinstance(i.value, float) and i.value != i.value
        ]:
            return f"no finite forecast: {', '.join(odd)}"
        path.write_text(write(scene), encoding="utf-8")
        return "" if loader.read(path) == scene else "does not survive being written and read"


def _build(scene: AnyScene) -> None:
    """The scene as objects, ready to start, where that takes seconds."""
    kind = KINDS[scene.kind]
    if isinstance(kind, TimeKind) and kind.sizes(scene).elements <= BUILT:
        kind.simulated(scene).simulation()


def _bad_refusal(damaged: Damaged, message: str) -> str:
    """What is wrong with a refusal."""
    if damaged.wanted == "accept":
        return f"refused: {message}"
    return "" if 0 < len(message) <= MESSAGE else f"a message of {len(message)} characters"


def _leaves(table: dict[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


def _taken(scene: Any, path: str, value: Any) -> bool:
    """Whether a scene has the value that its file gives."""
    at: Any = scene
    for name in path.split("."):
        at = getattr(at, name, None)
    if isinstance(at, InputFile):
        return at.name == value
    if isinstance(value, dict):
        return _same(at, value)
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return len(at) == len(value) and all(map(_same, at, value))
    return at == (tuple(value) if isinstance(value, list) else value)


def _same(at: Any, table: dict[str, Any]) -> bool:
    """Whether the object of an inline table has its values."""
    return all(_taken(at, key, value) for key, value in table.items())


def _numbers(scene: AnyScene) -> Iterator[tuple[str, float]]:
    for section in fields(scene):  # type: ignore[arg-type]
        part = getattr(scene, section.name)
        for key in fields(part) if is_dataclass(part) else ():
            value = getattr(part, key.name)
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, int | float):
                    yield f"{section.name}.{key.name}", number


def _sensible(value: float) -> bool:
    return value == 0 or (math.isfinite(value) and 1.0 / SIZE <= abs(value) <= SIZE)
