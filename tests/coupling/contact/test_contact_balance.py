"""Balloons pressed by slabs and by each other against exact balances; folds at rest."""

from functools import cache

import numpy as np
import pytest

from cases.geometry.bag_sampler import triangulated
from cases.geometry.folding import accordion_folding, roll_folding
from cases.geometry.pillows.folded import folded_bag
from coupling import BarrierContact, PlaneObstacle, SampledMesh, choose_contact
from shells.surfaces.pillow import Pillow

from .pressed import Balloon, balloon, settle

PRESSURE, REACH = 0.3, 0.05
RADIUS = 1.12202  # of the inflated unit sphere: p R0 = 2 (l - 1/l) C (1 + nu) / 2


def slabs(height: float) -> tuple[PlaneObstacle, PlaneObstacle]:
    return tuple(PlaneObstacle([s * height, 0, 0], [-s, 0, 0]) for s in (-1.0, 1.0))


@cache
def inflated(rows: int) -> tuple[Balloon, np.ndarray]:
    body = balloon(rows)
    free = BarrierContact(body.mesh, body.mesh.areas(body.rest), REACH, 4.0 * PRESSURE)
    return body, settle(body, free, RADIUS * body.rest, PRESSURE)[0]


def test_slabs_carry_their_load():
    """The load is what both slabs feel, and the work of a small approach over its length."""
    body, c = inflated(8)
    areas, loads, energies = body.mesh.areas(c), [], []
    for height in (0.8, 0.801, 0.799):
        contact = BarrierContact(body.mesh, areas, REACH, 4.0 * PRESSURE, slabs(height * RADIUS))
        c, energy, _ = settle(body, contact, c, PRESSURE)
        (left, right) = contact.reactions(c)
        assert left == pytest.approx(-right, abs=1e-6 * right[0])
        assert contact.force(c) == pytest.approx(np.zeros(3), abs=1e-6 * right[0])
        loads.append(right[0])
        energies.append(energy)
    work = (energies[2] - energies[1]) / (0.004 * RADIUS)
    assert loads[0] == pytest.approx(work, rel=1e-4)
    assert loads[1] < loads[0] < loads[2]


@pytest.mark.slow
def test_pressed_disc_has_the_pressure_inside():
    """A membrane that is flat carries nothing across: contact takes the pressure [1%, 2%]."""
    errors = []
    for rows in (12, 16):
        body, c = inflated(rows)
        contact = BarrierContact(
            body.mesh, body.mesh.areas(c), REACH, 4.0 * PRESSURE, slabs(0.8 * RADIUS)
        )
        c = settle(body, contact, c, PRESSURE)[0]
        x, now = body.mesh.sample @ c, body.mesh.areas(c)
        pressure = contact.pressure(c) * contact.areas / now
        load = contact.reactions(c)[1, 0]
        right, radius = x[:, 0] > 0.0, np.sqrt(load / (np.pi * PRESSURE))
        disc = now[right & (pressure > 0.5 * PRESSURE)].sum()
        assert load == pytest.approx(PRESSURE * disc, rel=0.02)
        core = right & (np.hypot(x[:, 1], x[:, 2]) < 0.5 * radius)
        errors.append(abs(np.average(pressure[core], weights=now[core]) / PRESSURE - 1.0))
    assert errors[1] < 0.015 < errors[0] < 0.06


def pair(rows: int) -> tuple[Balloon, SampledMesh, np.ndarray]:
    """Two inflated balloons side by side along x, within reach of each other."""
    body, c = inflated(rows)
    away = [RADIUS + 0.4 * REACH, 0.0, 0.0]
    mesh = SampledMesh.union([body.mesh, body.mesh])
    return body, mesh, np.concatenate([c - away, c + away])


def stack(mesh: SampledMesh, c: np.ndarray, height: float) -> BarrierContact:
    return BarrierContact(mesh, mesh.areas(c), REACH, 4.0 * PRESSURE, slabs(2.0 * height * RADIUS))


def test_two_balloons_push_each_other_alike():
    body, mesh, c = pair(8)
    contact = stack(mesh, c, 0.96)
    c = settle(body, contact, c, PRESSURE, aside=0.05)[0]
    left, right = contact.reactions(c)[:, 0]
    assert right == pytest.approx(-left, rel=1e-4)
    alone = BarrierContact(mesh, contact.areas, REACH, 4.0 * PRESSURE)
    forces = -alone.derivatives(c)[0].reshape(2, -1, 3)
    assert forces[0].sum(axis=0)[0] == pytest.approx(-right, rel=1e-4)
    assert forces.sum(axis=(0, 1)) == pytest.approx(np.zeros(3), abs=1e-14)
    spin = np.cross(c, forces.reshape(-1, 3)).sum(axis=0)
    assert spin == pytest.approx(np.zeros(3), abs=1e-14)
    assert not mesh.intersects(c)


@pytest.mark.slow
def test_two_balloons_share_a_disc_of_the_pressure_inside():
    """Pressure times disc is the force, and the pressure of its core that inside [3%]."""
    errors = []
    for rows in (12, 16):
        body, mesh, c = pair(rows)
        for height in (0.92, 0.8):
            contact = stack(mesh, c, height)
            c = settle(body, contact, c, PRESSURE, aside=0.05)[0]
        load = contact.reactions(c)[1, 0]
        alone = BarrierContact(mesh, contact.areas, REACH, 4.0 * PRESSURE)
        x, now = mesh.sample @ c, mesh.areas(c)
        pressure = alone.pressure(c) * alone.areas / now
        disc = 0.5 * now[pressure > 0.5 * PRESSURE].sum()  # both balloons have one
        core = np.hypot(x[:, 1], x[:, 2]) < 0.5 * np.sqrt(load / (np.pi * PRESSURE))
        core &= np.abs(x[:, 0]) < 0.5 * RADIUS
        inside = np.average(pressure[core], weights=now[core])
        errors.append([abs(load / (PRESSURE * disc) - 1.0), abs(inside / PRESSURE - 1.0)])
    assert (np.array(errors[1]) < 0.04).all()
    assert (np.array(errors[0]) < 0.08).all()
    assert (np.array(errors[1]) < 0.8 * np.array(errors[0])).all()


FOLDS = {
    "roll": (roll_folding(2.0, 1.0, 0.4), (36, 30), 0.142),
    "accordion": (accordion_folding(2, 6.0, 0.4), (28, 36), 0.15),
}


@pytest.mark.parametrize("fold", FOLDS)
def test_nothing_acts_on_a_fold_at_rest(fold):
    folding, size, share = FOLDS[fold]
    bag = folded_bag(Pillow(*size), folding)
    mesh = triangulated(bag, 3)
    numbers = choose_contact(mesh, bag.coefficients, bag.gap, 0.005)
    assert numbers.reach == pytest.approx(share * bag.gap, rel=1e-3)
    assert numbers.stiffness == 0.02
    assert (numbers.acting, numbers.remark) == (0, "")
    contact = BarrierContact(mesh, mesh.areas(bag.flat), numbers.reach, numbers.stiffness)
    assert contact.energy(bag.coefficients) == 0.0
    assert contact.distance(bag.coefficients) == np.inf
    further = BarrierContact(mesh, contact.areas, 1.1 * bag.gap, 1.0)
    assert further.within_reach(bag.coefficients) > len(contact.areas) // 2


def test_a_mesh_that_pinches_the_bag_is_told():
    bag = folded_bag(Pillow(20, 24), accordion_folding(4, 10.0, 0.4))
    mesh = triangulated(bag, 3)
    numbers = choose_contact(mesh, bag.coefficients, bag.gap, 0.005)
    assert numbers.reach == 0.1 * bag.gap
    assert numbers.acting > 0
    assert "refine the mesh" in numbers.remark
    with pytest.raises(ValueError, match="positive finite pressure"):
        choose_contact(mesh, bag.coefficients, bag.gap, 0.0)
