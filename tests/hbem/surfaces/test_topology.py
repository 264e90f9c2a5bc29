"""Closed, oriented surfaces and their components, from positions alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from cases.geometry.bodies import sphere, torus
from cases.geometry.pillows.pillow import accordion, round_bag
from hbem.surfaces.patches import BezierPatches, union
from hbem.surfaces.topology import SurfaceError, closed_components


def restricted(body: BezierPatches, kept: np.ndarray) -> BezierPatches:
    """Some elements of a body."""
    nb = (body.geometry_degree + 1) ** 2
    rows = np.concatenate([np.arange(body.indptr[e], body.indptr[e + 1]) for e in kept])
    points = (kept[:, None] * nb + np.arange(nb)).ravel()
    indptr = np.concatenate([[0], np.cumsum(np.diff(body.indptr)[kept])])
    return replace(
        body,
        indptr=indptr,
        dofs=body.dofs[rows],
        extraction=body.extraction[rows],
        bezier=body.bezier[points],
    )


def turned_inside_out(body: BezierPatches) -> BezierPatches:
    """The same surface with s reversed: normals inward."""
    nb = body.geometry_degree + 1
    order = np.arange(body.n_elements * nb * nb).reshape(-1, nb, nb)[:, ::-1].ravel()
    return replace(body, bezier=csr_matrix(body.bezier)[order])


@pytest.mark.parametrize(
    "body",
    [
        sphere(4, 5),
        torus(4, 4),
        round_bag(12, gap=0.01).patches(),
        accordion(44, 2).patches(),
    ],
    ids=["sphere", "torus", "pillow", "accordion"],
)
def test_closed_bodies_are_one_component(body):
    assert np.all(closed_components(body, body.coefficients) == 0)


def test_bag_of_membrane_and_inlet_is_one_component():
    from cases import loader
    from cases.kinds.inflation.initial_bag import initial_bag

    bag = initial_bag(loader.read("pancake"))
    both = union(bag.membrane, bag.inlet)
    assert np.all(closed_components(both, bag.coefficients) == 0)


def test_two_bodies_are_two_components():
    one = sphere(4, 5)
    both = union(one, one)
    apart = np.concatenate([one.coefficients, one.coefficients + np.array([0.0, 0.0, 2.001])])
    label = closed_components(both, apart)
    np.testing.assert_array_equal(label, np.repeat([0, 1], one.n_dofs))


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units_do_not_matter(scale):
    body = sphere(4, 5)
    assert np.all(closed_components(body, scale * body.coefficients) == 0)


def test_open_surfaces_are_refused():
    body = restricted(sphere(4, 5), np.arange(5, 20))
    with pytest.raises(SurfaceError, match=r"open: 5 edges.*cap"):
        closed_components(body, body.coefficients)


def test_inward_normals_are_refused():
    body = turned_inside_out(sphere(4, 5))
    with pytest.raises(SurfaceError, match="inwards; reverse"):
        closed_components(body, body.coefficients)


def test_mixed_orientation_is_refused():
    body = sphere(4, 5)
    flipped = turned_inside_out(body)
    first = np.arange(3 * (body.geometry_degree + 1) ** 2)
    rows = csr_matrix(body.bezier).tolil()
    rows[first] = flipped.bezier[first]
    with pytest.raises(SurfaceError, match="opposite orientation"):
        closed_components(replace(body, bezier=rows.tocsr()), body.coefficients)
