"""A shipped scene made ready to run in memory, and states of its run to start others from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from coupling import Fluid, State, Structure
from coupling.stepping.time_loop import Simulation

from ... import loader
from ...kinds import simulation
from ...kinds.inflation.config import InflationScene
from ...kinds.planar.config import PlanarScene
from ..recorded import RecordedHistory

CoupledScene = InflationScene | PlanarScene


@dataclass(frozen=True)
class Posed:
    """A scene with overrides, its simulation and the history that a run fills."""

    scene: CoupledScene
    simulation: Simulation
    history: RecordedHistory

    @property
    def structure(self) -> Structure:
        return self.simulation.structure

    @property
    def fluid(self) -> Fluid:
        assert self.simulation.fluid is not None
        return self.simulation.fluid

    def starting_from(self, state: State) -> Simulation:
        """The simulation from another state.

        Steps shorten by rejection only, so that all schemes solve the same equations.
        """
        control = replace(self.simulation.control, busy=float("inf"))
        return replace(self.simulation, initial=state, control=control)


def pose(name: str, options: Sequence[str]) -> Posed:
    """A shipped scene with overrides."""
    scene, history = loader.read(name, options), RecordedHistory()
    assert isinstance(scene, InflationScene | PlanarScene)
    return Posed(scene, simulation(scene, [history]), history)


def states(name: str, options: Sequence[str], times: Sequence[float]) -> list[State]:
    """States of an implicit run at the first steps after the given times."""
    last = [f"time.end={max(times)}"] if max(times) > 0.0 else []
    posed = pose(name, [*options, *last])
    if last:
        posed.simulation.run()
    found = posed.history.states or [posed.simulation.initial]
    return [next((s for s in found if s.t >= t - 1e-9), found[-1]) for t in times]
