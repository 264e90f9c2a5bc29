"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag

from coupling.contact.sampled_mesh import SampledMesh, grid_cells
from coupling.contact.self_intersection import Collision

from ...geometry.bag import Bag
from ...sections import SceneError
from .config import ContactTest

FINEST = 12  # cells per element side


def certified(body: Bag, contact: ContactTest) -> Collision:
    """Test of motions, refined until it finds the initial configuration free of contact.

    Raises
    ------
    SceneError
        Not even the finest test does.
    """
    tessellate = contact.tessellate
    while True:
        test = collision(body, tessellate, contact.engine)
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
        "ipctk", "bound", or "auto": ipctk.
    """
    n = tessellate + 1
    x = np.linspace(0.0, 1.0, n)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    elements = [part.n_elements for part in body.parts]
    sampling = block_diag([part.sample(xi, eta) for part in body.parts], format="csr")
    mesh = SampledMesh.of(sampling, grid_cells(sum(elements), n), body.coefficients)
    on_inlet = mesh.cells >= tessellate**2 * elements[0]
    chosen = "bound" if engine == "bound" else "ipctk"
    return Collision(mesh.sample, mesh.triangles, on_inlet, chosen)
