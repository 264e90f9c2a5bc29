"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from coupling.contact.on_demand import Carrying
from coupling.contact.self_intersection import Collision

from ..geometry.bag import Bag
from ..geometry.bag_sampler import triangulated
from ..sections import SceneError

FINEST = 12  # cells per element side


def certified(body: Bag, tessellate: int) -> Collision:
    """Test of motions, finer than ``tessellate`` where the initial bag is not found free on it.

    Raises
    ------
    SceneError
        Not even the finest test does.
    """
    while True:
        test = collision(body, tessellate)
        cause = test.inspect(body.coefficients, body.coefficients)
        if cause is None:
            return test
        if 2 * tessellate > FINEST:
            raise SceneError(
                [
                    f"contact.tessellate: the initial bag cannot be certified free of contact on "
                    f"{tessellate} cells a side ({cause.value}); refine the mesh at its folds, or "
                    "set contact.test = 'off'"
                ]
            )
        tessellate *= 2


def collision(body: Bag, tessellate: int = 3) -> Collision:
    """Test of motions of a bag, on ``tessellate`` cells per element side and finer in doubt."""
    mesh = triangulated(body, tessellate)
    element = mesh.cells // tessellate**2
    inlet = element >= body.membrane.n_elements
    finer = partial(collision, body, 2 * tessellate) if 2 * tessellate <= FINEST else None
    return Collision(mesh, inlet, element, body.gap, finer, body.coefficients)


def touched_elements(touching: Carrying, cells: int) -> Callable[[np.ndarray], np.ndarray]:
    """Elements with a sample that contact presses on, ``(n_elements,)`` bool of a configuration.

    Parameters
    ----------
    touching : BarrierContact or OnDemand
    cells : int
        Of its mesh, per element side.
    """
    mesh = touching.mesh
    element = mesh.cells // cells**2

    def touched(coefficients: np.ndarray) -> np.ndarray:
        pressed = (touching.pressure(coefficients) > 0.0)[mesh.triangles].any(axis=1)
        return np.bincount(element, pressed) > 0.0

    return touched
