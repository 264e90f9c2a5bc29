"""Ways to damage a run folder: every file in every general way, and each file in its own ways."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...output.checkpoint import CHECKPOINT, write_arrays

Damage = Callable[[Path, np.random.Generator], None]
TEXTS = ("history.csv", "iterations.log", "convergence.log", "run.json", "run.toml", "fields.pvd")


def files(folder: Path) -> list[str]:
    """Names of a run folder's files, but for its lock."""
    found = (p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    return sorted(name for name in found if name != "run.lock")


def damages(folder: Path) -> Iterator[tuple[str, Damage]]:
    """Names and functions of all damages that the files of a folder can take."""
    names = files(folder)
    for i, name in enumerate(names):
        for how, change in _BYTES.items():
            yield f"{name}: {how}", _changed(name, change)
        yield f"{name}: deleted", _deleted(name)
        yield f"{name}: is a folder", _as_folder(name)
        other = names[(i + 1) % len(names)]
        yield f"{name}: swapped with {other}", _swapped(name, other)
        if name in TEXTS:
            for how, edit in _LINES.items():
                yield f"{name}: {how}", _edited(name, edit)
    for name, pairs in _WORDS.items():
        for old, new in pairs if name in names else ():
            yield f"{name}: {new!r} for {old!r}"[:90], _replaced(name, old, new)
    for key, values in _VALUES.items():
        for value in values:
            for signed in (False, True):
                how = "hashed" if signed else "edited"
                yield f"{CHECKPOINT}: {how}, {key} = {value}", _posed(key, value, signed)
    yield "run.toml: without its last table", _changed("run.toml", _without_tail)
    yield "fields/: deleted", _no_frames
    yield "everything but run.toml: deleted", _only_scene
    yield "history and checkpoint: deleted", _no_rows


def flipped(folder: Path, rng: np.random.Generator) -> str:
    """Flip one bit of one file; says which."""
    name = str(rng.choice(files(folder)))
    data = bytearray((folder / name).read_bytes())
    place, bit = int(rng.integers(len(data))), int(rng.integers(8))
    data[place] ^= 1 << bit
    (folder / name).write_bytes(data)
    return f"{name}: bit {bit} of byte {place}"


def _noise(data: bytes, rng: np.random.Generator) -> bytes:
    middle = len(data) // 2
    return data[:middle] + rng.bytes(16) + data[middle + 16 :]


_BYTES: Mapping[str, Callable[[bytes, np.random.Generator], bytes]] = {
    "emptied": lambda data, rng: b"",
    "cut in half": lambda data, rng: data[: len(data) // 2],
    "cut by a byte": lambda data, rng: data[:-1],
    "without its first half": lambda data, rng: data[len(data) // 2 :],
    "cut anywhere": lambda data, rng: data[: rng.integers(1, len(data))],
    "zeros in the middle": lambda d, rng: d[: len(d) // 2] + bytes(16) + d[len(d) // 2 + 16 :],
    "noise in the middle": _noise,
    "all noise": lambda data, rng: rng.bytes(len(data)),
    "twice": lambda data, rng: data + data,
    "noise at the end": lambda data, rng: data + rng.bytes(40),
}

_LINES: Mapping[str, Callable[[list[str]], list[str]]] = {
    "a line is missing": lambda lines: lines[:2] + lines[3:],
    "two lines change places": lambda lines: [*lines[:2], lines[3], lines[2], *lines[4:]],
    "a line comes twice": lambda lines: [*lines[:3], *lines[2:]],
    "other line ends": lambda lines: [line.replace("\n", "\r\n") for line in lines],
    "another last digit": lambda lines: [*lines[:2], _digit(lines[2]), *lines[3:]],
    "without its head": lambda lines: lines[1:],
    "only its head": lambda lines: lines[:1],
    "NaN for numbers": lambda lines: [re.sub(r"\d+\.\d+", "nan", line) for line in lines],
}

_WORDS: Mapping[str, list[tuple[str, str]]] = {
    "fields.pvd": [
        ("fields/frame_000000.vtu", "../../frame_000000.vtu"),
        ("fields/frame_000000.vtu", "/etc/passwd"),
        ("fields/frame_000000.vtu", "fields/frame_999999.vtu"),
        ('timestep="0.0"', ""),
        ('timestep="0.0"', 'timestep="then"'),
        ("<Collection>", '<!DOCTYPE x [<!ENTITY a "a">]><Collection>'),
    ],
    "run.json": [
        ("{", "[", ),
        ('"sessions": [', '"sessions": 3, "x": ['),
        ('"skips": [', '"skips": {}, "x": ['),
        ("{", "[" * 100_000),
        ("{", '{"n": ' + "9" * 5000 + ","),
    ],
    "run.toml": [
        ('name = "', 'name = "../../'),
        ("[time]", "[time"),
        ("end = ", "end = -"),
        ("dt = ", "dt = 1"),
        ('kind = "inflation"', 'kind = "shell"'),
        ("fields_every = 1", "fields_every = 5"),
        ("fields_every = 1", "fields_every = 0"),
        ("end = 32.0", "end = 8.0"),
    ],
}  # fmt: skip

_VALUES: Mapping[str, list[Any]] = {
    "dt": [np.nan, 0.0, -1.0, np.inf, "x", 1j, [1.0, 2.0], None],
    "t": [np.nan, -1.0, 1e9, np.inf, "x", [1.0], None],
    "step": [-1, 3.5, 10**6, np.nan, "x", None],
    "pressure": [np.nan, 1j, None],
    "coefficients": [0.0, [[1.0, 2.0, 3.0]], [np.nan], [[1j]], [["a"]], None],
    "velocity": [0.0, [[1.0, 2.0, 3.0]], [[np.inf]], [[1]], None],
    "increment": [np.nan, [1.0], None],
    "accumulated.pressure_work": [np.nan, "x", None],
    "format": [1, 99, "x", None],
    "scene": ["0", 3.0, None],
    "hash": ["0", None],
    "sealed.name": [["../history.csv"], [], None],
    "sealed.size": [[-1], [], None],
}


def _changed(name: str, change: Callable[[bytes, np.random.Generator], bytes]) -> Damage:
    def damage(folder: Path, rng: np.random.Generator) -> None:
        (folder / name).write_bytes(change((folder / name).read_bytes(), rng))

    return damage


def _edited(name: str, edit: Callable[[list[str]], list[str]]) -> Damage:
    return _changed(
        name, lambda data, rng: "".join(edit(data.decode().splitlines(keepends=True))).encode()
    )


def _replaced(name: str, old: str, new: str) -> Damage:
    return _changed(name, lambda data, rng: data.replace(old.encode(), new.encode(), 1))


def _digit(line: str) -> str:
    """The line with another last digit in its first half."""
    places = [i for i, letter in enumerate(line[: len(line) // 2 + 1]) if letter.isdigit()]
    if not places:
        return line
    i = places[-1]
    return line[:i] + str((int(line[i]) + 1) % 10) + line[i + 1 :]


def _without_tail(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: data.rindex(b"\n[")]


def _deleted(name: str) -> Damage:
    return lambda folder, rng: (folder / name).unlink()


def _as_folder(name: str) -> Damage:
    def damage(folder: Path, rng: np.random.Generator) -> None:
        (folder / name).unlink()
        (folder / name).mkdir()

    return damage


def _swapped(one: str, other: str) -> Damage:
    def damage(folder: Path, rng: np.random.Generator) -> None:
        first, second = (folder / one).read_bytes(), (folder / other).read_bytes()
        (folder / one).write_bytes(second)
        (folder / other).write_bytes(first)

    return damage


def _posed(key: str, value: Any, signed: bool) -> Damage:
    """A checkpoint with another value (None: without it), as a program would write it."""

    def damage(folder: Path, rng: np.random.Generator) -> None:
        path = folder / CHECKPOINT
        with np.load(path) as file:
            arrays = dict(file)
        arrays.pop(key, None)
        if value is not None:
            arrays[key] = np.asarray(value)
        if signed and key not in ("format", "scene", "hash"):
            write_arrays(
                path, {k: a for k, a in arrays.items() if k != "hash"}, str(arrays["scene"])
            )
        else:
            np.savez(path, **arrays)

    return damage


def _no_frames(folder: Path, rng: np.random.Generator) -> None:
    for file in (folder / "fields").iterdir():
        file.unlink()
    (folder / "fields").rmdir()


def _only_scene(folder: Path, rng: np.random.Generator) -> None:
    _no_frames(folder, rng)
    for name in files(folder):
        if name != "run.toml":
            (folder / name).unlink()


def _no_rows(folder: Path, rng: np.random.Generator) -> None:
    for name in ("history.csv", CHECKPOINT):
        (folder / name).unlink()


def sessions(folder: Path) -> int:
    """Number of sessions that run.json knows of."""
    return len(json.loads((folder / "run.json").read_text(encoding="utf-8"))["sessions"])
