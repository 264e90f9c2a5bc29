"""Forces depend neither on where a body is, nor on the unit of length, nor on any numbering."""

from dataclasses import replace

import numpy as np
import pytest

from cases.benchmarks.honesty.disguises import AWAY, reordered
from cases.geometry.bodies import sphere, spheroid
from cases.geometry.pillows.pillow import round_bag
from hbem.flows.stokes_flow import StokesFlow
from hbem.surfaces.patches import SurfacePatches, union
from hbem.surfaces.topology import SurfaceError, closed_components

PULL = np.array([0.3, -0.2, 1.0])


def drag(patches: SurfacePatches, coefficients: np.ndarray) -> np.ndarray:
    return StokesFlow(patches, coefficients, measure="none").traction(PULL).force()[0]


def bodies() -> dict[str, tuple[SurfacePatches, np.ndarray]]:
    """A sphere, a flat ellipsoid and a flat bag with their configurations."""
    bag = round_bag(8, gap=0.05)
    exact = {"sphere": sphere(4, 5), "ellipsoid": spheroid(6, 4, c=0.2, grading=0.5)}
    return {
        **{k: (b, b.coefficients) for k, b in exact.items()},
        "bag": (bag.patches(), bag.coefficients),
    }


BODIES = bodies()


@pytest.mark.parametrize("name", BODIES)
def test_position_and_unit(name):
    """Rounding of coordinates 1e8 away is 1e-8 of the body, and 1e-6 of a gap of a hundredth."""
    patches, x = BODIES[name]
    expected = drag(patches, x)
    for shift, allowed in ((2e4, 1e-10), (1e8, 1e-6)):
        np.testing.assert_allclose(drag(patches, x + shift * AWAY), expected, rtol=allowed)
    for unit in (1e-30, 1e30):
        np.testing.assert_allclose(drag(patches, unit * x) / unit, expected, rtol=1e-12)


def test_drag_far_from_the_origin_is_that_of_stokes():
    body = sphere(6, 6)
    found = drag(body, body.coefficients + 2e4 * AWAY)
    np.testing.assert_allclose(found, 6.0 * np.pi * PULL, rtol=1e-6)


def test_beyond_the_reach_of_double_precision_is_refused_with_the_figure():
    body = sphere(6, 6)
    with pytest.raises(ValueError, match=r"0\.5.* rounded to 0\.0001: beyond double precision"):
        StokesFlow(body, body.coefficients + 1e12 * AWAY)
    for unit in (1e-200, 1e200):
        with pytest.raises(ValueError, match=r"measures 2.*e.200: beyond double precision.*unit"):
            StokesFlow(body, unit * body.coefficients)


def test_a_gap_as_narrow_as_rounding_is_refused():
    bag = round_bag(8, gap=0.005)
    with pytest.raises(ValueError, match=r"rounded to 1e-08 in a gap of 0\.0099.*open the gap"):
        StokesFlow(bag.patches(), bag.coefficients + 1e8 * AWAY, tolerance=1e-5)
    mixed = [
        sphere(4, 5),
        replace(sphere(4, 5), coefficients=1e-8 * sphere(4, 5).coefficients + 10.0 * AWAY),
    ]
    with pytest.raises(ValueError, match=r"edge of length .*bring bodies closer"):
        StokesFlow(union(*mixed))


def test_field_and_torque_far_from_the_origin():
    body, shift = sphere(6, 6), 1e7 * AWAY
    near = StokesFlow(body, measure="none").traction(PULL)
    far = StokesFlow(body, body.coefficients + shift, measure="none").traction(PULL)
    x = np.array([[0.0, 0.0, 1.5], [0.5, 0.0, 0.0], [3.0, 1.0, 0.0]])
    found, expected = far.field(x + shift), near.field(x)
    np.testing.assert_allclose(found.velocity, expected.velocity, atol=1e-7)
    np.testing.assert_array_equal(found.inside, expected.inside)
    np.testing.assert_allclose(far.torque(shift), near.torque(), atol=1e-6)


@pytest.mark.parametrize("compression", ["dense", "h2"])
def test_numbering(compression):
    """What is compressed may differ by its own error."""
    body = spheroid(6, 4, c=0.4)
    other = reordered(body, 1)
    forces = [
        StokesFlow(b, compression=compression, measure="none").traction(PULL).force()[0]
        for b in (body, other)
    ]
    np.testing.assert_allclose(*forces, rtol=1e-11 if compression == "dense" else 1e-4)


def test_elements_given_twice_are_called_duplicates():
    body = sphere(4, 4)
    rows = np.arange(body.indptr[-1])
    twice = replace(
        body,
        indptr=np.concatenate([body.indptr, body.indptr[-1] + body.indptr[1:]]),
        dofs=np.tile(body.dofs, 2),
        extraction=body.extraction[np.tile(rows, 2)],
        bezier=body.bezier[np.tile(np.arange(body.bezier.shape[0]), 2)],
    )
    with pytest.raises(SurfaceError, match=r"16 elements are given twice: element 16 duplicates"):
        closed_components(twice, twice.coefficients)
    e = 5
    net = 81 * e + np.arange(81).reshape(9, 9).T.ravel()  # turned over, with opposite normal
    part = slice(body.indptr[e], body.indptr[e + 1])
    once = replace(
        body,
        indptr=np.append(body.indptr, body.indptr[-1] + part.stop - part.start),
        dofs=np.append(body.dofs, body.dofs[part]),
        extraction=np.concatenate([body.extraction, body.extraction[part]]),
        bezier=body.bezier[np.concatenate([np.arange(body.bezier.shape[0]), net])],
    )
    with pytest.raises(SurfaceError, match=r"1 elements are given twice: element 16 .* element 5"):
        closed_components(once, once.coefficients)
