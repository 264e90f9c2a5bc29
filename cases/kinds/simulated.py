"""A scene with time as objects, and the one place where they become a `Simulation`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from coupling import CollisionTest, Fluid, Recorder, Simulation, State, Structure, Tolerances
from coupling.contact.on_demand import Carrying
from coupling.contact.watch import Watch
from coupling.schemes.contraction import measure_contraction
from coupling.schemes.scheme import Scheme
from coupling.stepping.integrator import BDF2, BackwardEuler
from coupling.stepping.step_control import StepControl

from ..output.accuracy import Accuracy
from ..output.vtk import SurfaceSampler
from ..sections import TimedScene
from .schemes import iterations


@dataclass(frozen=True)
class Simulated:
    """What a scene comes to, worked out once.

    Attributes
    ----------
    scene : TimedScene
    structure : Structure
    fluid : callable, optional
        Makes the fluid model, new at each call (a model keeps operators and preconditioners);
        None for uniform pressure.
    scheme : Scheme
    volume : callable
        Enclosed volume at a time.
    initial : State
    sampler : SurfaceSampler
        Grids of configurations for files and pictures.
    diagnostics : callable
        State to further columns of the history.
    skips : tuple of str
        What this scene does not need and a run leaves out.
    collision : CollisionTest, optional
        Test of configurations for self-intersection.
    watch : Watch, optional
        From when on they are tested; default always.
    contact : BarrierContact or OnDemand, optional
        What the structure's steps carry load with.
    accuracy : Accuracy, optional
        Budget of the boundary integrals, reviewed at the end of a run.
    """

    scene: TimedScene
    structure: Structure
    fluid: Callable[[], Fluid] | None
    scheme: Scheme
    volume: Callable[[float], float]
    initial: State
    sampler: SurfaceSampler
    diagnostics: Callable[[State], Mapping[str, float]]
    skips: tuple[str, ...]
    collision: CollisionTest | None = None
    watch: Watch | None = None
    contact: Carrying | None = None
    accuracy: Accuracy | None = None

    def simulation(self, recorders: Sequence[Recorder] = ()) -> Simulation:
        """The run, ready to start."""
        t, c = self.scene.time, self.scene.coupling
        return Simulation(
            structure=self.structure,
            fluid=self.fluid() if self.fluid is not None else None,
            scheme=self.scheme,
            volume=self.volume,
            initial=self.initial,
            control=StepControl(
                t.dt, t.end, t.step_growth, t.dt_floor, error=t.error, closing=t.closing
            ),
            tolerances=Tolerances(c.tolerance, c.absolute_tolerance, iterations(c)),
            recorders=recorders,
            diagnostics=self.diagnostics,
            checkpoint_every=self.scene.output.checkpoint_every,
            integrator=BDF2() if t.integrator == "bdf2" else BackwardEuler(),
            collision=self.collision,
            watch=self.watch,
            contact=self.contact,
        )

    def measured_contraction(self, state: State | None = None) -> float:
        """rho at the scene's dt by power iteration on the fluid assembled on one configuration.

        Raises
        ------
        ValueError
            A scene with a uniform pressure, which has no fluid.
        """
        if self.fluid is None:
            raise ValueError("a uniform pressure has no contraction: there is no fluid")
        c = self.initial.coefficients if state is None else state.coefficients
        at = State(0.0, c, np.zeros_like(c)) if state is None else state
        dt = self.scene.time.dt
        inverse = self.structure.linearised(at, dt)
        return measure_contraction(self.fluid().assemble(c).response(), inverse, dt)
