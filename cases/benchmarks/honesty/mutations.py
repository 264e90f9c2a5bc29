"""Damaged scenes, seeded: mutated tables, extreme values, raw files.

Each is the text of a file and what may become of it: ``refuse`` where accepting it would be silent
nonsense, ``accept`` where refusing it would be wrong, ``build`` where what is accepted must be
buildable, else either.
"""

from __future__ import annotations

import random
import tomllib
from codecs import BOM_UTF8
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import Field, dataclass, fields
from typing import Any, get_type_hints

from ...kinds import KINDS
from ...kinds.inflation.mesh_config import UNITS
from ...limits import literal
from ...scene_file import home_of, names, text_of
from ...sections import Choice

Table = dict[str, Any]


@dataclass(frozen=True)
class Damaged:
    """One damaged scene.

    Attributes
    ----------
    case : str
        What was done to which scene.
    data : bytes
        The file.
    wanted : {"refuse", "accept", "either", "build"}
    overrides : tuple of str
        As given by ``--set``.
    """

    case: str
    data: bytes
    wanted: str = "either"
    overrides: tuple[str, ...] = ()


class Raw(str):
    """A value as it stands in a file."""


DEEP = 3000
WRONG_TYPES = (
    Raw("[]"), Raw("{}"), Raw("[[]]"), Raw("1979-05-27"), Raw("07:32:00"), Raw("{a = {b = 1}}"),
    Raw('["a", 1]'), Raw("[{}]"), Raw('["' + "x" * 5000 + '"]'),
)  # fmt: skip
NONSENSE = (
    Raw("nan"), Raw("inf"), Raw("-inf"), Raw("1e400"), Raw("-1e400"), Raw("1e308"), Raw("-1e308"),
    Raw("1" + "0" * 30), Raw("-1" + "0" * 30), Raw("9" * 400), Raw("1" + "0" * 4400),
    Raw("0x" + "f" * 9000), Raw("1e-306"), Raw("5e-324"),
    Raw("[" * DEEP + "]" * DEEP), Raw("{a=" * DEEP + "1" + "}" * DEEP),
)  # fmt: skip
EDGES = (Raw("0"), Raw("-1"), Raw("1"), Raw("0.0"), Raw("-1.0"), Raw("1e-9"), Raw("3000"),
         Raw("1e5"), Raw("1000000"), Raw("1e9"))  # fmt: skip


# what a mesh needs besides its word: lengths are those of the file
MESH = {"file": (home_of("bag-stl") / "meshes/bag.stl").as_posix(), "crease": 55.0,
        "inlet": {"sphere": [0.0, 0.0, 0.0, 50.0]}}  # fmt: skip


def toml(table: Mapping[str, Any]) -> bytes:
    """A table as a file."""
    lines = [f"{key} = {_value(v)}" for key, v in table.items() if not isinstance(v, dict)]
    for key, part in table.items():
        if isinstance(part, dict):
            lines += [f"[{key}]", *(f"{name} = {_value(v)}" for name, v in part.items())]
    return ("\n".join(lines) + "\n").encode()


def _value(value: Any) -> str:
    return str(value) if isinstance(value, Raw) else literal(value)


def _text(scene: str) -> str:
    """A shipped scene that finds its mesh from any folder."""
    return text_of(scene).replace('"meshes/', f'"{home_of(scene).as_posix()}/meshes/')


def mutated(count: int, seed: int, scenes: list[str]) -> Iterator[Damaged]:
    """Shipped scenes with one change each."""
    rng = random.Random(seed)
    changes = (_deleted, _retyped, _scaled, _nonsense, _swapped, _nested, _misspelt)
    for k in range(count):
        scene = rng.choice(scenes)
        text = _text(scene)
        if k % (len(changes) + 1) == len(changes):
            yield _bytes(rng, scene, text.encode())
            continue
        table = tomllib.loads(text)
        section = rng.choice([key for key in table if isinstance(table[key], dict)])
        part, key = table[section], rng.choice(sorted(table[section]))
        change = changes[k % (len(changes) + 1)]
        yield change(rng, f"{scene}: {section}.{key}", table, part, key)


def _deleted(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    del part[key]
    if rng.random() < 0.2:
        part.clear()
    return Damaged(f"{case} deleted", toml(table))


def _retyped(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    value = part[key]
    others = [t for t in (True, "words", 3) if type(t) is not type(value)]
    if isinstance(value, float):
        others.remove(3)  # a whole number is a number
    part[key] = rng.choice([*others, *WRONG_TYPES])
    if rng.random() < 0.1:
        where = rng.choice(sorted(table))
        table[where] = Raw("[]")
        return Damaged(f"{case} retyped, {where} = []", toml(table), "refuse")
    return Damaged(f"{case} = {part[key]!s:.40}", toml(table), "refuse")


def _scaled(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    value = part[key]
    if isinstance(value, bool | str | list):
        return _nonsense(rng, case, table, part, key)
    factor = 10.0 ** rng.uniform(-40.0, 40.0) * rng.choice((1.0, 1.0, -1.0))
    new = value * factor
    part[key] = int(new) if isinstance(value, int) else new
    far = part[key] != 0 and not 1e-15 < abs(part[key]) < 1e15
    return Damaged(f"{case} = {part[key]:.3g}", toml(table), "refuse" if far else "either")


def _nonsense(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    part[key] = rng.choice(NONSENSE)
    return Damaged(f"{case} = {part[key]!s:.40}", toml(table), "refuse")


def _swapped(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    """A key moves to another section, or two values change places."""
    other = table[rng.choice([k for k in table if isinstance(table[k], dict)])]
    if rng.random() < 0.5:
        other[key] = part.pop(key)
        return Damaged(f"{case} moved", toml(table))
    second = rng.choice(sorted(other)) if other else key
    other = other or part
    part[key], other[second] = other[second], part[key]
    return Damaged(f"{case} and {second} exchanged", toml(table))


def _nested(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    depth = rng.choice((1, 2, 50, 400, DEEP))
    inner = _value(part[key])
    left, right = rng.choice((("[", "]"), ("{x = ", "}")))
    part[key] = Raw(left * depth + inner + right * depth)
    return Damaged(f"{case} nested {depth} deep", toml(table), "refuse")


def _misspelt(rng: random.Random, case: str, table: Table, part: Table, key: str) -> Damaged:
    wrong = key + rng.choice("xyz_") if rng.random() < 0.5 else key[1:] + "_"
    part[wrong] = part.pop(key)
    return Damaged(f"{case} misspelt {wrong}", toml(table), "refuse")


def _bytes(rng: random.Random, scene: str, data: bytes) -> Damaged:
    damaged = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 10))):
        place, how = rng.randrange(len(damaged)), rng.randrange(4)
        if how == 0:
            damaged[place] = rng.randrange(256)
        elif how == 1:
            damaged.insert(place, rng.randrange(256))
        elif how == 2:
            del damaged[place : place + rng.randrange(1, 30)]
        else:
            damaged[place:place] = damaged[place : place + rng.randrange(1, 80)]
        damaged = damaged or bytearray(b"\n")
    return Damaged(f"{scene}: bytes damaged", bytes(damaged))


def keys() -> Iterator[tuple[str, Table, str, Field[Any], Any]]:
    """Every key of every section: kind, the scene that has it, section, field and type."""
    for kind in KINDS.values():
        for name, section in kind.sections.items():
            words = section.tables if isinstance(section, Choice) else {"": section}
            for word, table in words.items():
                scene: Table = {"kind": kind.name}
                if isinstance(section, Choice):
                    part, key = section.key.split(".")
                    scene[part] = {key: word} | (MESH if word == "mesh" else {})
                hints = get_type_hints(table)
                for f in fields(table):
                    scene_with = deepcopy(scene)
                    scene_with.setdefault(name, {})
                    yield kind.name, scene_with, name, f, hints[f.name]


def extremes(count: int, seed: int) -> Iterator[Damaged]:
    """Extreme values of every number of every section, in minimal scenes."""
    numbers = [entry for entry in keys() if entry[4] in (int, float) or _pair(entry[4])]
    cases = [(entry, v) for entry in numbers for v in (*NONSENSE, *EDGES)]
    for (kind, scene, section, key, type_), value in random.Random(seed).sample(cases, count):
        scene = deepcopy(scene)
        size = len(type_.__args__) if _pair(type_) else 0
        shown = Raw(f"[{', '.join([value] * size)}]") if size else value
        scene[section][key.name] = shown
        wanted = "refuse" if value in NONSENSE else "either"
        yield Damaged(f"{kind}: {section}.{key.name} = {shown!s:.40}", toml(scene), wanted)


def ends() -> Iterator[Damaged]:
    """Both ends of every range, in minimal scenes: what is allowed there must be buildable."""
    for kind, scene, section, key, type_ in keys():
        limits = key.metadata
        if "choices" in limits or not (type_ in (int, float) or _pair(type_)):
            continue
        kinds = type_.__args__ if _pair(type_) else (type_,)
        low = limits.get("least", limits.get("above", 0.0) + 1e-3)
        high = limits.get("most", limits.get("below", 1.0) - 1e-3)
        for value in (low, high):
            entries = [kind_(value) for kind_ in kinds]
            chosen = deepcopy(scene)
            chosen[section][key.name] = entries if _pair(type_) else entries[0]
            yield Damaged(f"{kind}: {section}.{key.name} = {value:g}", toml(chosen), "build")


def _pair(type_: Any) -> bool:
    return getattr(type_, "__origin__", None) is tuple


def minimal() -> Iterator[Damaged]:
    """Scenes of one word each: every shape, model, scheme and law there is, all else by default."""
    for kind, scene, section, key, type_ in keys():
        for value in key.metadata.get("choices", ()) if type_ is str else ():
            chosen = deepcopy(scene)
            chosen[section][key.name] = value
            if f"{section}.{key.name}" == "geometry.unit" and value:
                chosen["physical"] = _physical(UNITS[value])
            yield Damaged(f"{kind}: {section}.{key.name} = {value}", toml(chosen), "accept")


def _physical(length: float) -> Table:
    """SI values of a bag whose L is a length."""
    return {"length": length, "thickness": length, "young_modulus": 1e6} | {
        key: 1.0 for key in ("areal_density", "viscosity")
    }


def raw(seed: int) -> Iterator[Damaged]:
    """Files that are no scenes, or scenes in other encodings."""
    rng = random.Random(seed)
    text = text_of("pancake-pressure")
    data = text.encode()
    yield Damaged("byte order mark", BOM_UTF8 + data, "accept")
    yield Damaged("empty", b"", "accept")
    yield Damaged("two ends of a line", data.replace(b"\n", b"\r\n"), "accept")
    for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7"):
        yield Damaged(encoding, text.replace("'", "é").encode(encoding), "either")
    yield Damaged("latin-1", 'name = "é"'.encode("latin-1"), "refuse")
    pieces = (b"\0", b"\xff\xfe", b"[" * 100000, b"]", b"[[a]]", b"a.b.c = 1", b"[a]\n[a]",
              b"a = 1\na = 2", b"=", b"a =", b'a = "', b"a = 1\rb = 2", b"\x1b[31m", b"kind = []",
              b"kind = {}", b"kind = 3", b"kind = nan", b'kind = "', b"name = 3", b"name = []",
              b"name = ''", b'name = "/"', b'name = "../../x"', b"geometry = []",
              b"[[geometry]]", b"geometry.kind = []", b"[geometry]\nkind = {}",
              b"[geometry.kind]\na = 1", b"physical = 1", b"[physical]", b"[physical]\nlength = []",
              b"[time]\ndt = " + b"9" * 5000, b"a" * 1_000_000, b"a." * DEEP + b"a = 1",
              b'name = "' + b"x" * 1_000_000 + b'"', b"\x89PNG\r\n\x1a\n")  # fmt: skip
    for piece in pieces:
        yield Damaged(f"{piece[:30]!r}", piece + b"\n", "refuse")
    for k in range(12):
        yield Damaged(f"noise {k}", rng.randbytes(1 + 40 * k), "refuse" if k else "either")
        yield Damaged(f"cut {k}", data[: rng.randrange(len(data))])


def overridden() -> Iterator[Damaged]:
    """What ``--set`` may be given by mistake."""
    data = text_of("pancake-pressure").encode()
    bad = ("", "=", "a", "time", "time.dt=", "=3", ".=1", "..=1", "time..dt=1", "time.dt.x=1",
           "kind=[]", "kind=3", "kind={}", "geometry.kind=[]", "geometry.kind={}", "geometry=3",
           "geometry.kind.x=1", "time.dt=1\nend=3", "time.dt=[[1]]", "time.dt=" + "9" * 5000,
           "time.dt=" + "[" * DEEP, "time.dt=" + "[" * DEEP + "]" * DEEP, "x" * 100_000 + "=1",
           "a." * DEEP + "a=1", "time.dt=\udcff", "\udcff=1", "name=", "name=../x",
           "fluid.model=[]", "mesh={}\nx=1", "physical.length=1", "time.dt=\0")  # fmt: skip
    for item in bad:
        yield Damaged(f"--set {item!a:.40}", data, "refuse", (item,))
    good = ("time.dt = 4", "output.picture=false", "geometry.kind=pillow", "mesh={}", "name=a-1.b",
            'description="[x] {y}"', "kind=capsule")  # fmt: skip
    for item in good:
        wanted = "either" if item == "kind=capsule" else "accept"
        yield Damaged(f"--set {item}", data, wanted, (item,))


def shipped_scenes(quick: bool) -> list[str]:
    """Scenes to mutate: those that are checked at once, or all."""
    slow = ("accordion", "crumple", "roll", "pillow") if quick else ()
    return [name for name in names() if not name.startswith(slow or ("-",))]
