"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag

from coupling.contact.sampled_mesh import SampledMesh, available, grid_cells
from coupling.contact.self_intersection import Collision

from ...geometry.bag import Bag
from ...sections import SceneError
from .config import Scene

pass  # import gone


FINEST = 12  # cells per element side


def certified(body: Bag, tessellate: int, engine: str) -> Collision:
    """Test of motions, refined until it finds the initial configuration free of contact.

    Raises
    ------
    SceneError
        Not even the finest test does.
    """
    while True:
        test = collision(body, tessellate, engine)
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


def collision(body: Bag, tessellate: int = 3, engine: str = "auto") -> Collision:
    """Test of motions of a bag; samples of neighbouring elements are made one.

    Parameters
    ----------
    tessellate : int
        Cells per element side, two triangles each.
    engine : str
        "ipctk", "bound", or "auto": ipctk where it is installed.

    Raises
    ------
    ValueError
        "ipctk" asked for and not installed.
    """
    if engine == "ipctk" and not available():
        raise ValueError("contact.engine: 'ipctk' needs the extra: pip install airfold[contact]")
    n = tessellate + 1
    x = np.linspace(0.0, 1.0, n)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    elements = [part.n_elements for part in body.parts]
    sampling = block_diag([part.sample(xi, eta) for part in body.parts], format="csr")
    mesh = SampledMesh.of(sampling, grid_cells(sum(elements), n), body.coefficients)
    on_patch = mesh.cells >= tessellate**2 * elements[0]
    chosen = "ipctk" if engine != "bound" and available() else "bound"
    return Collision(mesh.sample, mesh.triangles, on_patch, chosen)


def _tested(scene: Scene) -> bool:
    """Whether configurations are tested for self-intersection."""
    g = scene.geometry
    folded = g.kind == "pillow" and (g.fold != "flat" or g.crumple > 0.0)
    return scene.contact.test == "on" or (scene.contact.test == "auto" and folded)


def _collision(scene: Scene, body: Bag) -> object | None:
    if not _tested(scene):
        return None
    return certified(body, scene.contact.tessellate, scene.contact.engine)
