"""Trials of compressed matrices against dense ones, and of forces in disguise."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from hbem.compression.h2matrix import h2matrix
from hbem.compression.hmatrix import hmatrix
from hbem.compression.operator import Compressed
from hbem.compression.point_kernel import TEST_RANDOM, probe_densities
from hbem.flows.stokes_flow import StokesFlow
from hbem.surfaces.patches import BezierPatches

from ...geometry.bodies import sphere, spheroid
from ...geometry.pillows.pillow import round_bag
from .clouds import CLOUDS, GRADED, dense, normals
from .disguises import AWAY, CLOUD_DISGUISES, reordered

Trial = dict[str, str | float | bool]
METHODS: Mapping[str, Callable[..., Compressed]] = {"aca": hmatrix, "h2": h2matrix}
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
DISGUISED: tuple[float, ...] = (1e-3, 1e-6)  # tolerances of the disguised clouds
SAME = 1e-6  # relative difference of forces that a disguise may make
SHIFTS = (1e1, 1e2, 1e4, 2e4, 1e6, 1e7, 1e8, 1e10, 1e12)
UNITS = (1e-300, 1e-200, 1e-100, 1e-30, 1e-6, 1e6, 1e30, 1e100, 1e200, 1e300)
PULL = np.array([0.3, -0.2, 1.0])


def trials(quick: bool) -> list[Trial]:
    """All trials, or a reduced set.

    Parameters
    ----------
    quick : bool
        One cloud in three and few disguises: some seconds.

    Returns
    -------
    list of dict
        ``promise``, ``case``, ``tolerance``, ``error``, and ``refused``: whether the program said
        that it cannot keep the tolerance. The error of an input that was refused is NaN.
    """
    with quiet():
        return [*_matrix_trials(quick), *_force_trials(quick)]


@contextmanager
def quiet() -> Iterator[None]:
    """No warnings in the log meanwhile: every one of them is a trial's ``refused``."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)


def _matrix_trials(quick: bool) -> Iterator[Trial]:
    clouds = {**CLOUDS, **GRADED}
    disguised: tuple[float, ...] = DISGUISED
    if quick:
        disguised = DISGUISED[-1:]
        clouds = {name: clouds[name][::3] for name in ("stack", "fold", "graded to 5e-8")}
    for name, points in clouds.items():
        plain = points, normals(name, points)
        yield from _cloud_trials(name, *plain, (1e-3, 1e-6) if quick else TOLERANCES)
        disguises = {} if quick and name != "fold" else CLOUD_DISGUISES
        for what, disguise in disguises.items():
            yield from _cloud_trials(f"{name}, {what}", *disguise(*plain), disguised)


def _cloud_trials(
    name: str, points: np.ndarray, directions: np.ndarray, tolerances: tuple[float, ...]
) -> Iterator[Trial]:
    """Both layers of a cloud by both methods, random and constant densities apart."""
    n = points.shape[0]
    x = probe_densities(n, 5).reshape(3 * n, -1)
    # a constant of random direction, which the package does not try itself
    x = np.c_[x, x[:, -3:] @ np.random.default_rng(5).standard_normal(3)]
    kinds = {"random": slice(0, TEST_RANDOM), "constant": slice(TEST_RANDOM, None)}
    for layer, given in (("V", None), ("K", directions)):
        exact = dense(points, given) @ x
        size = np.linalg.norm(exact, axis=0)
        for method, build in METHODS.items():
            for tolerance in tolerances:
                operator = build(points, tolerance, normals=given, leaf=32)
                away = np.linalg.norm(operator @ x - exact, axis=0)
                error = away / np.where(size > 0.0, size, 1.0)
                for kind, columns in kinds.items():
                    yield {
                        "promise": f"compressed {layer}, {kind} density",
                        "case": f"{name}, {method} at {tolerance:g}",
                        "tolerance": tolerance,
                        "error": float(error[columns].max()),
                        "refused": not operator.statistics.achieved <= tolerance,
                    }


def _force_trials(quick: bool) -> Iterator[Trial]:
    """The force on a body elsewhere, in other units, renumbered."""
    bag = round_bag(8, gap=0.05)
    bodies = {
        "sphere": sphere(4, 5),
        "ellipsoid": spheroid(6, 4, c=0.2, grading=0.5),
        "bag": replace(bag.patches(), coefficients=bag.coefficients),
    }
    for name, body in dict(list(bodies.items())[: 1 if quick else None]).items():
        expected = _force(body)
        assert body.coefficients is not None
        for shift in (2e4, 1e12) if quick else SHIFTS:
            other = replace(body, coefficients=body.coefficients + shift * AWAY)
            yield _compared("position", f"{name} {shift:g} away", other, 1.0, expected)
        for unit in (1e-30, 1e200) if quick else UNITS:
            other = replace(body, coefficients=unit * body.coefficients)
            yield _compared("unit", f"{name}, {unit:g} of the unit", other, unit, expected)
        for seed in range(1 if quick else 3):
            other = reordered(body, seed)
            yield _compared("numbering", f"{name}, order {seed}", other, 1.0, expected)


def _force(body: BezierPatches) -> np.ndarray:
    return StokesFlow(body).traction(PULL).force()[0]


def _compared(
    promise: str, case: str, body: BezierPatches, unit: float, expected: np.ndarray
) -> Trial:
    error, refused = np.nan, False
    try:
        found = _force(body) / unit
        error = float(np.linalg.norm(found - expected) / np.linalg.norm(expected))
    except ValueError:
        refused = True
    return {
        "promise": f"force, {promise}",
        "case": case,
        "tolerance": SAME,
        "error": error,
        "refused": refused,
    }
