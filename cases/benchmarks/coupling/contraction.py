"""Contraction rho of subiterations three ways: by formula, as spectral radius, as measured.

The spectral radius is that of the assembled Gauss-Seidel map; what is measured is the growth of a
small disturbance over one true subiteration.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from coupling import State, Structure
from coupling.schemes.contraction import film_symbol, worst_mode
from shells.energy.material import Material
from shells.equilibrium.structure import ShellStructure

from ...kinds.inflation.config import InflationScene
from ...kinds.inflation.plan import InflationPlan
from ...kinds.planar.build import bag
from ..report import Row
from .posed import Posed, pose


def contraction_row(name: str, options: Sequence[str], state: State, m: float, dt: float) -> Row:
    """rho three ways; in the plane the formula takes the film of the state itself."""
    start = time.process_time()
    options = [*options, f"time.dt={dt}", f"time.end={dt}", f"fluid.mass_ratio={m}"]
    options.append("coupling.reuse_tolerance=0")
    posed = pose(name, options)
    scene = posed.scene
    middle = unloaded(posed.structure, state, dt)
    response = posed.fluid.assemble(middle.coefficients).response()
    inverse = posed.structure.linearised(middle, dt)
    radius, mode = worst_mode(response, inverse, dt, tolerance=1e-9)
    ratio = measured_ratio(posed, state, middle, dt, mode)
    if isinstance(scene, InflationScene):
        forecast = InflationPlan(scene).contraction
        soft = pose(name, [*options, "structure.stiffness=1e-6"])
        inertia = soft.structure.linearised(middle, dt)
        more = {"radius, inertia alone": worst_mode(response, inertia, dt)[0]}
    else:
        assert isinstance(posed.structure, ShellStructure)
        body, material = bag(scene), posed.structure.shell.material
        surface = 2.0 * np.pi / float(np.diff(body.nodes).min())
        film = planar_film(material, body.inlet, state, dt, scene.geometry.radius)
        forecast = m * dt * max(surface, film)
        more = {"antisymmetric": asymmetry(mode)}
    return {
        "case": f"{name}, t = {state.t:g}: contraction",
        "seconds": time.process_time() - start,
        "error": abs(ratio / radius - 1.0),
        "reference": "spectral radius",
        "mass_ratio": m,
        "dt": dt,
        "spectral radius": radius,
        "residual ratio": ratio,
        "a priori": forecast,
        "a priori / radius": forecast / radius,
        **more,
    }


def unloaded(structure: Structure, state: State, dt: float) -> State:
    """The structure's own step: where the subiterations' structure solve is linearised."""
    step = structure.step(state, None, dt, structure.volume(state.coefficients))
    if not step.ok:
        raise ArithmeticError(f"unloaded structure step: {step.outcome.value}")
    found = step.state
    return State(found.t, found.coefficients, found.velocity, found.pressure)


def measured_ratio(
    posed: Posed,
    state: State,
    middle: State,
    dt: float,
    mode: np.ndarray,
    size: float = 1e-5,
) -> float:
    """Growth of a small disturbance ``mode`` of ``middle`` over one true subiteration.

    Assembly on the disturbed shape, fluid solve and Newton; its two signs are compared. The worst
    mode is antisymmetric where a symmetric run would hide it.
    """
    mode = mode.reshape(state.coefficients.shape)
    volume = posed.structure.volume(state.coefficients)

    def subiteration(x: np.ndarray) -> np.ndarray:
        disturbed = posed.fluid.assemble(x)
        load = disturbed.load(disturbed.traction((x - middle.coefficients) / dt))
        step = posed.structure.step(state, load, dt, volume, guess=middle.coefficients)
        return step.state.coefficients if step.ok else np.full_like(x, np.nan)

    still = middle.coefficients
    change = subiteration(still + size * mode) - subiteration(still - size * mode)
    return float(np.linalg.norm(change)) / (2.0 * size)


def asymmetry(mode: np.ndarray) -> float:
    """Share of a planar mode that is antisymmetric: sheets move up on one side, down on the other.

    Positions are the even rows; the mirror image runs backwards, x changes sign.
    """
    x = mode.reshape(-1, 2)[::2]
    odd = 0.5 * (x - x[::-1] * np.array([-1.0, 1.0]))
    return float(np.linalg.norm(odd) / np.linalg.norm(x))


def planar_film(
    material: Material, inlet: np.ndarray, state: State, dt: float, radius: float
) -> float:
    """S of the film between the upper sheet, from tip to tip, and what lies below it.

    Within a step that a membrane wave needs to run around a tip (a half circle at the start) the
    tips are stiff, and the film ends where they begin.
    """
    x = state.coefficients[::2]
    right, left = int(x[:, 0].argmax()), int(x[:, 0].argmin())
    upper = x[right : left + 1]
    lower = np.concatenate([x[left:], inlet, x[: right + 1]])
    lower = lower[np.argsort(lower[:, 0])]
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(upper, axis=0), axis=1)))
    thickness = upper[:, 1] - np.interp(upper[:, 0], *lower.T)
    stiff = dt * np.sqrt(material.stiffness / material.density) > np.pi * radius
    tip = 0.5 * np.pi * radius if stiff else 0.0
    part = (thickness > 0.05 * np.median(thickness)) & (s >= tip) & (s <= s[-1] - tip)
    return film_symbol(s[part], thickness[part])
