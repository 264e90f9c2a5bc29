"""The error of a compressed operator, measured on exact rows; built again until it is met."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .operator import EXACT, TEST_RANDOM, Compressed, log


def test_densities(n: int, seed: int) -> np.ndarray:
    """Random densities, then the three constant ones, ``(n, 3, TEST_RANDOM + 3)``."""
    random = np.random.default_rng(seed).standard_normal((n, 3, TEST_RANDOM))
    return np.concatenate([random, np.tile(np.eye(3), (n, 1, 1))], axis=2)


def measured(operator: Compressed, requested: float, seed: int) -> Compressed:
    """The operator with measured errors and apply time in its statistics."""
    x = test_densities(operator.statistics.n, seed)
    errors = operator.relative_error(x, seed)
    began = time.perf_counter()
    operator.apply(x[:, :, :1])
    operator.statistics = replace(
        operator.statistics,
        requested=requested,
        error_random=float(errors[:TEST_RANDOM].max()),
        error_constant=float(errors[TEST_RANDOM:].max()),
        apply_seconds=time.perf_counter() - began,
    )
    return operator


def verified(
    build: Callable[[float], Compressed], tolerance: float, seed: int, exact: Callable
) -> Compressed:
    """Build, measure, build again at a quarter, and at last sum exactly: never silent."""
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance must lie between 0 and 1, got {tolerance}")
    for target in (tolerance, tolerance / 4.0):
        if target < EXACT:
            note = f"tolerance {tolerance:.1e} leaves nothing to compress"
            break
        operator = measured(build(target), tolerance, seed)
        if operator.statistics.achieved <= tolerance:
            return operator
        note = f"error {operator.statistics.achieved:.1e} above the tolerance {tolerance:.1e}"
        log.warning("%s (built at %.1e): %s", operator.statistics.method, target, note)
        del operator
    note += ": exact sums"
    log.warning("not compressed: %s", note)
    return measured(exact(note), tolerance, seed)
