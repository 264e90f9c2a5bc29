"""Write the mesh files of shipped scenes: ``python -m cases.scenes.meshes.make``.

They are of about 300 kB at most and made by formulas, so that anybody can change and remake them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from .disc_deck import disc_deck
from .flat_pattern import pattern_obj
from .round_bag import bag_stl

FILES: Mapping[str, Callable[[], bytes]] = {
    "bag.stl": bag_stl,
    "disc.k": disc_deck,
    "pattern.obj": pattern_obj,
}
FOLDER = Path(__file__).parent


def main() -> None:
    """Write all files beside this module."""
    for name, made in FILES.items():
        (FOLDER / name).write_bytes(made())


if __name__ == "__main__":
    main()
