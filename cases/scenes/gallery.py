"""The gallery of scenes: one picture, command and duration a scene, kept from finished runs.

``python -m cases.scenes.gallery add RUN_FOLDER...`` takes runs into ``gallery.json`` and their
pictures into ``cases/pictures``; ``... write`` writes both lists anew: the gallery in this folder's
README and the list of scenes in the main one. Nothing there is typed by hand.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from PIL import Image

from .. import loader
from ..kinds import FOLDERS, KINDS
from ..limits import literal
from ..output.atomic import replacing
from ..scene_text import TOP, field_names
from ..sections import AnyScene

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
RECORDS, PICTURES = FOLDER / "gallery.json", FOLDER.parent / "pictures"
README, GALLERY = ROOT / "README.md", FOLDER / "README.md"
WIDTH, BYTES = 900, 150_000  # largest picture
MORE = {  # pictures of a run folder beside its overview, and what they show
    "beside": "Beside a uniform pressure, at equal volumes",
    "loads": "Contact (red) and wrinkled zones (blue)",
}
BUSY = 1.5  # load average of a machine that did other work beside a run
MACHINE = ("processor", "cores", "memory_GB", "OMP_NUM_THREADS")
Entry = Mapping[str, Any]


def add(folder: Path, load: float, commit: str) -> None:
    """Take a finished run into the records, in the place of the scene's former one.

    Parameters
    ----------
    folder : Path
        A run folder with run.toml, run.json and overview.png; beside.png and loads.png, where
        `airfold report` has drawn them, come along.
    load : float
        Load average of the machine while it ran.
    commit : str
        Of the code that ran.
    """
    entry = entry_of(folder, load, commit)
    records = {**read(), entry["scene"]: entry}
    shrink(folder / "overview.png", PICTURES / f"{entry['scene']}.png")
    for more in entry["more"]:
        shrink(folder / f"{more}.png", PICTURES / f"{entry['scene']}-{more}.png")
    with replacing(RECORDS) as file:
        json.dump(dict(sorted(records.items())), file, indent=1)
        file.write("\n")


def read() -> dict[str, Entry]:
    """The records by scene."""
    return json.loads(RECORDS.read_text(encoding="utf-8")) if RECORDS.exists() else {}


def entry_of(folder: Path, load: float, commit: str) -> Entry:
    """The record of a run folder."""
    scene, run = loader.read(folder / "run.toml"), json.loads((folder / "run.json").read_text())
    sessions = run["sessions"]
    counts = {key: n for key, n in sessions[-1].get("counts", {}).items() if n}
    return {
        "scene": scene.name,
        "command": " ".join(["airfold run", scene.name, *(f"--set {o}" for o in changes(scene))]),
        "seconds": sum(session["seconds"] for session in sessions),
        "result": run["result"],
        "advice": run.get("advice", ""),
        "counts": {"steps": run.get("step", sessions[-1].get("step", 0)), **counts},
        "t": run.get("t", sessions[-1].get("t")),
        "end": getattr(getattr(loader.read(scene.name), "time", None), "end", None),
        "machine": {key: run["machine"][key] for key in MACHINE if key in run["machine"]},
        "load": load,
        "versions": run["versions"],
        "commit": commit,
        "date": sessions[0]["started"][:10],
        "more": [name for name in MORE if (folder / f"{name}.png").exists()],
    }


def changes(scene: AnyScene) -> Iterator[str]:
    """What a scene has other than the shipped scene of its name, as ``--set`` takes it.

    Keys of ``output`` but the seed change what is written, not the run.
    """
    shipped = loader.read(scene.name)
    for section in field_names(type(scene)):
        part, usual = getattr(scene, section), getattr(shipped, section)
        if section in TOP or part is None or part == usual:
            continue
        for key in field_names(type(part)):
            if section == "output" and key != "seed":
                continue
            if (value := getattr(part, key)) != getattr(usual, key, None):
                yield f"{section}.{key}={literal(value)}"


def shrink(source: Path, target: Path) -> None:
    """A picture small enough for a repository: fewer pixels, then fewer colours."""
    image = Image.open(source).convert("RGB")
    if image.width > WIDTH:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        image = image.resize(size, Image.Resampling.LANCZOS)
    for colours in (256, 128, 64, 32):
        image.quantize(colours, dither=Image.Dither.NONE).save(target, optimize=True)
        if target.stat().st_size <= BYTES:
            return


def gallery(records: Mapping[str, Entry]) -> str:
    """The gallery in Markdown, kind by kind."""
    return "\n".join(
        line
        for title, names in by_kind()
        for line in [f"## {title}", "", *(part for name in names for part in _shown(records[name]))]
    ).rstrip("\n")


def scene_list() -> str:
    """All shipped scenes, one line a kind, with links into the gallery."""
    link = "[`{0}`](cases/scenes/README.md#{0})"
    return "\n".join(
        f"- **{title}**: {', '.join(link.format(name) for name in names)}"
        for title, names in by_kind()
    )


def by_kind() -> Iterator[tuple[str, list[str]]]:
    """What each kind is, by the first line of its folder, and its shipped scenes."""
    kinds = {name: loader.read(name).kind for name in loader.shipped()}
    for folder, kind in zip(FOLDERS, KINDS, strict=True):
        about = import_module(f"cases.kinds.{folder}").__doc__ or kind
        title = about.splitlines()[0].rstrip(".")
        yield title, [name for name in kinds if kinds[name] == kind]


def ending(entry: Entry) -> str:
    """How a run ended, in words."""
    t, end = entry["t"], entry["end"]
    where = f"after {entry['counts']['steps']} steps"
    if t is not None:
        where += f", at t = {t:g}" + (f" of {end:g}" if end and t < 0.999 * end else "")
    word = {
        "completed": "completed" if "--set" not in entry["command"] else "reduced run, completed",
        "interrupted": "stopped by hand, to be continued by `airfold resume`,",
    }.get(entry["result"], f"`{entry['result'].upper()}`")
    advice = f": {entry['advice']}" if entry["result"] != "completed" and entry["advice"] else ""
    return f"{word} {where}{advice}"


def fill(text: str, marker: str, content: str) -> str:
    """Text with new content between ``<!-- marker -->`` and the next ``<!-- end -->``."""
    head, _, rest = text.partition(f"<!-- {marker} -->\n")
    _, end, tail = rest.partition("<!-- end -->")
    if not end:
        raise ValueError(f"no <!-- {marker} --> with its <!-- end -->")
    return f"{head}<!-- {marker} -->\n{content}\n{end}{tail}"


def pages() -> Iterator[tuple[Path, str]]:
    """The files with generated parts and what they should hold."""
    yield README, fill(README.read_text(encoding="utf-8"), "scenes", scene_list())
    yield GALLERY, fill(GALLERY.read_text(encoding="utf-8"), "gallery", gallery(read()))


def _shown(entry: Entry) -> Iterable[str]:
    name, machine = entry["scene"], entry["machine"]
    about = loader.shipped()[name]
    threads = f", {machine['OMP_NUM_THREADS']} thread" if "OMP_NUM_THREADS" in machine else ""
    beside = " beside other jobs" if entry["load"] > BUSY else ""
    load = f"load {entry['load']:.1f} on {machine['cores']} cores"
    return [
        f"### {name}",
        "",
        f"{about[0].upper()}{about[1:]} ([`{name}.toml`]({name}.toml)).",
        "",
        f"![{name}](../pictures/{name}.png)",
        "",
        *(line for more in entry.get("more", []) for line in _more(name, more)),
        f"`{entry['command']}`: {entry['seconds']:.0f} s{beside} ({load}{threads}, "
        f"{entry['date']}, commit {entry['commit']}); {ending(entry)}.",
        "",
    ]


def _more(name: str, more: str) -> tuple[str, ...]:
    return f"{MORE[more]}:", "", f"![{name}, {more}](../pictures/{name}-{more}.png)", ""


def _commit() -> str:
    done = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True
    )
    return done.stdout.strip() or "unknown"


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m cases.scenes.gallery")
    commands = parser.add_subparsers(required=True, dest="command", metavar="COMMAND")
    adding = commands.add_parser("add", help="take finished runs into the records")
    adding.add_argument("folders", metavar="RUN_FOLDER", type=Path, nargs="+")
    adding.add_argument(
        "--load",
        type=float,
        default=os.getloadavg()[1],
        help="load average while they ran (default: that of the last five minutes)",
    )
    adding.add_argument("--commit", default=_commit(), help="of the code that ran (default: HEAD)")
    commands.add_parser("write", help="write the lists of scenes anew")
    options = parser.parse_args(arguments)
    if options.command == "add":
        for folder in options.folders:
            add(folder, options.load, options.commit)
        return
    for path, text in pages():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
