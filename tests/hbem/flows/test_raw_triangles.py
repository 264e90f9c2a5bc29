"""Flows on raw triangulations, as mesh files hold them."""

import numpy as np
import pytest

from cases.benchmarks.meshes import flow as rows
from cases.benchmarks.meshes.raw_bodies import raw_ellipsoid, raw_sphere
from hbem.flows.stokes_flow import StokesFlow
from hbem.near.facing_gap import closest_facing
from hbem.surfaces import narrowest_gap
from hbem.surfaces.narrowest_gap import narrowest
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample

BODY = raw_sphere(100)


def sampled(patches):
    return sample(patches, patches.coefficients, QuadratureOrders())


def test_raw_means_irregular():
    """A third of the vertices have six neighbours."""
    valences = np.bincount(BODY.triangles.ravel())
    assert 0.25 < np.mean(valences == 6) < 0.45
    assert valences.min() >= 4


@pytest.mark.parametrize("density", [1, 2])
def test_strain_of_a_sphere(density):
    """Measured 0.97 and 0.84 of the best with own normals; drag -2.1e-4."""
    row = rows.sphere_row(BODY, "quadratic", density, measure="none")
    assert row["error/best"] < 1.0
    assert abs(row["drag"]) < 3e-4


def test_the_mesh_s_share_of_linear_densities():
    """Measured 1.03 with 196 triangles; 0.69 by a larger space of the same degree."""
    row = rows.sphere_row(raw_sphere(50), "quadratic", 1)
    assert 0.9 < row["estimate/error"] < 1.15, row["estimate/error"]


@pytest.mark.parametrize("geometry", ["quadratic", "cubic from normals"])
def test_flow_inside_is_solved_as_well_as_can_be(geometry):
    """Both layers, exact on any geometry: measured 1.02."""
    assert rows.inside_row("sphere", BODY, geometry, 1)["error/best"] < 1.03


def test_filling_a_raw_bag_leaves_no_flux():
    """Measured 6.5e-5 of the largest velocity."""
    assert rows.enclosed_row(100)["error"] < 1e-4


def test_gaps_of_fat_bodies_are_left_out(monkeypatch):
    """Only what no table knows: thin gaps are found as by a search without bounds."""
    sphere, thin = sampled(BODY.patches()), sampled(raw_ellipsoid(100, 0.15).patches())
    assert closest_facing(sphere) is None
    assert narrowest(sphere).thinness > 0.35
    found = narrowest(thin)
    monkeypatch.setattr(narrowest_gap, "FAT", 100.0)
    assert narrowest(sphere).thinness > 0.35
    assert narrowest(thin) == found


def test_parallel_facets_are_no_thin_film():
    """Rounding of their curvature is not the length of a film: thinness 2e-9 before."""
    flow = StokesFlow(raw_ellipsoid(100, 0.15).patches(degree=1), measure="none")
    assert flow.facing is not None
    assert flow.budget.thinness > 0.1
