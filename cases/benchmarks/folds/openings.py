"""Folded bags opened: every shipped one by a flow and by a uniform pressure, each a row."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ... import loader
from ...kinds.inflation.config import InflationScene
from ...kinds.inflation.plan import InflationPlan
from ...runs.start import start
from ...sections import SceneError
from ..report import Row
from .like import named
from .opened import measured

QUICK = (
    "accordion-2-coarse",
    [
        "structure.reference=creased",
        "inflow.final_volume=3.0",
        "inflow.t1=20.0",
        "inflow.t2=80.0",
        "time.dt=8.0",
        "time.end=104.0",
    ],
)
PRESSURE = "fluid.model=pressure"


def run(quick: bool) -> Iterator[Row]:
    """Run every shipped folded bag in Stokes flow and under uniform pressure, and measure it.

    ``quick``: a coarse accordion under uniform pressure alone.
    """
    names = [name for name in loader.shipped() if _folded(loader.read(name))]
    runs = [(name, [o]) for name in names for o in (PRESSURE, "fluid.model=stokes")]
    if quick:
        name, overrides = QUICK
        runs = [(name, [*overrides, PRESSURE])]
    with tempfile.TemporaryDirectory() as place:
        folders = []
        for k, (name, overrides) in enumerate(runs):
            folders.append(Path(place) / str(k))
            failed = _run(name, [*overrides, "output.fields_every=1"], folders[-1])
            if failed:
                yield failed
                folders.pop()
                continue
            # the run under uniform pressure comes first
            yield measured(folders[-1], folders[:-1])


def _folded(scene: object) -> bool:
    return isinstance(scene, InflationScene) and InflationPlan(scene).folded


def _run(name: str, overrides: Sequence[str], folder: Path) -> Row | None:
    """Run a scene; a row of its failure where it cannot be built."""
    from rich.console import Console

    scene = loader.read(name, [*overrides, "output.picture=false"])
    assert isinstance(scene, InflationScene)  # folded bags are
    try:
        start(scene, folder, Console())
    except SceneError as error:
        failed = {"result": "NOT BUILT", "seconds": 0.0, "error": np.nan}
        return {**named(scene), **failed, "reference": f"none: {error}"}
    return None
