"""Kinds of scenes, one folder each: read `kind.py` (what a kind is), then `inflation`.

A new kind is a folder with its ``KIND`` and the folder's name in `FOLDERS`. ``simulated.py``
assembles what kinds with time have in common, ``schemes.py`` and ``inflow.py`` turn sections into
coupling schemes and prescribed volumes, ``collision.py`` a bag into its test of contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from .kind import Kind, TimeKind

if TYPE_CHECKING:
    from coupling import Recorder
    from coupling.stepping.time_loop import Simulation

    from ..sections import AnyScene

FOLDERS = ("inflation", "capsule", "adaptive_flow", "planar", "load_path")
_FOUND: list[Kind] = [import_module(f"{__name__}.{folder}").KIND for folder in FOLDERS]
# The word of a scene -> its kind; a scene that says none is of the first.
KINDS: dict[str, Kind] = {kind.name: kind for kind in _FOUND}


def simulation(scene: AnyScene, recorders: Sequence[Recorder] = ()) -> Simulation:
    """The run of a scene as an object, without a folder.

    Parameters
    ----------
    scene : scene of a kind with time
        From `cases.loader.read`.
    recorders : sequence of Recorder
        Hear about every step.

    Raises
    ------
    TypeError
        A scene of a kind without time (load paths, model-adaptive flows).
    """
    kind = KINDS[scene.kind]
    if not isinstance(kind, TimeKind):
        raise TypeError(f"scenes of kind {scene.kind!r} have no time; run them by `airfold run`")
    return kind.simulated(scene).simulation(recorders)
