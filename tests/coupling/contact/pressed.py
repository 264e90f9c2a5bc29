"""Inflated balloons in contact: the minimum of membrane energy, pressure's work and barrier."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, diags
from scipy.sparse.linalg import splu

from cases.geometry.revolution import sphere
from coupling import BarrierContact, SampledMesh
from coupling.contact.sampled_mesh import grid_cells
from shells import EnclosedVolume, KirchhoffLove, Material, SurfaceBasis, extraction


@dataclass(frozen=True)
class Balloon:
    """A unit sphere of thin membrane; its poles lie aside of where it is pressed, along x."""

    shell: KirchhoffLove
    volume: EnclosedVolume
    extraction: object
    rest: np.ndarray
    mesh: SampledMesh


def balloon(rows: int, cells: int = 3) -> Balloon:
    surface, c = sphere(3, rows, 2 * rows)
    basis = SurfaceBasis(surface, c)
    shell = KirchhoffLove(basis, Material(1e-7, poisson_ratio=0.3))
    x = np.linspace(0.0, 1.0, cells + 1)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    sampling, elements = surface.sample(xi, eta), surface.n_elements
    mesh = SampledMesh.of(sampling, grid_cells(elements, cells + 1), c)
    return Balloon(shell, EnclosedVolume(basis), extraction(surface.reduction), c, mesh)


def settle(
    body: Balloon,
    contact: BarrierContact,
    start: np.ndarray,
    pressure: float,
    aside: float = 0.0,
) -> tuple[np.ndarray, float, int]:
    """Balloons of one kind in equilibrium: coefficients, energy and Newton iterations.

    Springs of stiffness ``aside`` over the area hold them across x, as a stack slips sideways.
    """
    count, n = start.shape[0] // body.rest.shape[0], body.rest.size
    E = block_diag(count * [body.extraction], format="csr")
    full_mass = block_diag(count * [body.shell.basis.mass(1.0)], format="csr")
    across = diags(np.tile([0.0, 1.0, 1.0], start.shape[0]))
    mass, spring = E.T @ full_mass @ E, aside * across @ full_mass
    home = start.ravel().copy()

    def potential(c: np.ndarray) -> float:
        own = [
            sum(body.shell.energy(part)) - pressure * body.volume.value(part)
            for part in np.split(c, count)
        ]
        held = 0.5 * float((c - home) @ (spring @ (c - home)))
        return sum(own) + held + contact.energy(c.reshape(-1, 3))

    c, shift = start.ravel().copy(), 1e-3
    value = potential(c)
    for iteration in range(200):
        gradient, tangent = contact.derivatives(c.reshape(-1, 3), projected=False)
        gradient, blocks = gradient + spring @ (c - home), []
        for k, part in enumerate(np.split(c, count)):
            g, K = body.shell.gradient_and_tangent(part)
            _, dQ, ddQ = body.volume.derivatives(part)
            gradient[k * n : (k + 1) * n] += g - pressure * dQ
            blocks.append(K - pressure * ddQ)
        K = E.T @ (tangent + spring + block_diag(blocks, format="csr")) @ E
        r = E.T @ gradient
        while True:
            step = E @ splu((K + shift * mass).tocsc()).solve(-r)
            end = (c + step).reshape(-1, 3)
            full = contact.free_step(c.reshape(-1, 3), end)
            trial = c + full * step
            lower = potential(trial)
            if lower <= value + 1e-13 * abs(value) and np.abs(step).max() < 0.3:
                break
            shift = 4.0 * max(shift, 1e-6)
            assert shift < 1e6, "no descent"
        c, value, shift = trial, lower, max(0.25 * shift, 1e-7)
        if full == 1.0 and np.abs(step).max() < 1e-6:
            return c.reshape(-1, 3), value, iteration + 1
    raise AssertionError(f"not in equilibrium: last step {np.abs(step).max():.2g}")
