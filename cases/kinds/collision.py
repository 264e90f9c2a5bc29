"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

from functools import partial

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
