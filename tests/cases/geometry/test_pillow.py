"""Pillow bodies: smoothness, approximation orders, the fold map.

Measured: area and volume errors of the sphere 6.9e-5, 6.5e-7, 2.5e-8 and 6.9e-5, 2.5e-7, 4e-10
for n = 16, 32, 64; spread of normals about a corner at 0.1, 0.01, 0.001 elements 4.8e-4, 4.9e-6,
4.9e-8 (fit), 3.6e-3, 4.1e-4, 4.2e-5 (random smooth field), 0.07 always without the condition.
"""

from __future__ import annotations

import numpy as np
import pytest

from cases.geometry.fold import PlanarCurve, roll, zigzag
from cases.geometry.pillows.pillow import (
    accordion,
    fit,
    flattened,
    rectangle,
    round_bag,
    unit_sphere,
)
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample
from shells.surfaces.pillow import Pillow
from shells.surfaces.splines import bernstein
from shells.surfaces.surface_basis import SurfaceBasis


def at(surface: Pillow, coefficients: np.ndarray, s: np.ndarray, t: np.ndarray) -> tuple:
    """Points, tangents s and t at parameters in the unit square."""
    i = np.minimum((s * surface.n_s).astype(int), surface.n_s - 1)
    j = np.minimum((t * surface.n_t).astype(int), surface.n_t - 1)
    xi, eta = s * surface.n_s - i, t * surface.n_t - j
    e = i * surface.n_t + j
    local = np.einsum("eak,eac->ekc", surface.tables[e], coefficients[surface.element_dofs[e]])
    local = local.reshape(-1, 3, 3, 3)
    values = [
        np.einsum("ip,jp,pijc->pc", bernstein(2, xi, d), bernstein(2, eta, f), local)
        for d, f in ((0, 0), (1, 0), (0, 1))
    ]
    normal = np.cross(values[1], values[2])
    return values[0], normal / np.linalg.norm(normal, axis=1, keepdims=True)


def random_field(surface: Pillow, smooth: bool) -> np.ndarray:
    """Ellipsoid-like coefficients with a random part, corners smooth or not."""
    rng = np.random.default_rng(1)
    base, _ = fit(surface)
    noise = 0.02 * rng.standard_normal((surface.n_coefficients, 3))
    if not smooth:
        return base + noise
    return base + surface.reduction @ noise[: surface.reduction.shape[1]]


def test_zipped_ends_are_smooth():
    surface = Pillow(16, 8)
    c = random_field(surface, smooth=True)
    s = (np.arange(200) + 0.5) / 200
    for end in (0.0, 1.0):
        inside = np.full_like(s, abs(end - 1e-9))
        x, n = at(surface, c, s, inside)
        y, m = at(surface, c, 1.0 - s, inside)
        assert np.abs(x - y).max() < 1e-7
        # d_s and d_t both change sign across the zip, the normal does not; away from the corners
        far = (s % 0.5 > 0.05) & (s % 0.5 < 0.45)
        assert np.abs(n - m)[far].max() < 1e-6


def corner_spreads(surface: Pillow, coefficients: np.ndarray) -> np.ndarray:
    """Largest deviation of normals on rings of 0.1, 0.01, 0.001 elements about a corner."""
    angle = np.linspace(1e-3, np.pi - 1e-3, 41)
    spread = []
    for r in (0.1, 0.01, 0.001):
        s, t = r / surface.n_s * np.cos(angle) % 1.0, r / surface.n_t * np.sin(angle)
        _, n = at(surface, coefficients, s, t)
        spread.append(np.linalg.norm(n - n.mean(axis=0), axis=1).max())
    return np.array(spread)


def test_corners_are_smooth_under_their_condition():
    surface = Pillow(16, 8)
    fitted, _ = fit(surface, flattened(0.3), rectangle(2.0, 1.0))
    assert np.all(corner_spreads(surface, fitted) < [1e-2, 1e-4, 1e-6])  # O(r^2)
    random = corner_spreads(surface, random_field(surface, smooth=True))
    assert np.all(random < [1e-2, 1e-3, 1e-4])  # O(r)
    cone = corner_spreads(surface, random_field(surface, smooth=False))
    assert np.all(cone > 0.05)


def test_sphere_converges_with_the_fourth_order():
    errors = []
    for n in (16, 32, 64):
        bag = unit_sphere(n)
        outer = sample(bag.patches(), bag.coefficients, QuadratureOrders(outer=4)).outer
        volume = outer.weights @ np.sum(outer.points * outer.normals, axis=1) / 3.0
        errors.append((outer.weights.sum() / (4 * np.pi) - 1, volume * 0.75 / np.pi - 1))
    errors = np.abs(errors)
    assert np.all(errors[1] < 1e-6)
    assert np.all(np.log2(errors[:-1] / errors[1:]) > 3.9)


def test_curvature_converges_with_the_first_order():
    """Rms error of the mean curvature; the four corners do not degrade it."""
    rms = []
    for n in (16, 32, 64):
        bag = unit_sphere(n)
        basis = SurfaceBasis(bag.surface, bag.coefficients)
        j = basis.jets(bag.coefficients)
        normal = j.normal / np.linalg.norm(j.normal, axis=-1, keepdims=True)
        e, f, g = (
            np.sum(a * b, -1)
            for a, b in ((j.grad[0],) * 2, (j.grad[0], j.grad[1]), (j.grad[1],) * 2)
        )
        ll, nn, mm = (np.sum(h * normal, -1) for h in j.hess)
        mean = -0.5 * (e * nn - 2 * f * mm + g * ll) / (e * g - f * f)
        rms.append(np.sqrt(np.sum(basis.dx * (mean - 1.0) ** 2) / basis.dx.sum()))
    assert rms[2] < 0.02
    assert np.log2(rms[1] / rms[2]) > 0.95


def test_functions_of_a_density_sum_to_one():
    bag = round_bag(8, gap=0.2)
    patches = bag.patches()
    surface = sample(patches, bag.coefficients, QuadratureOrders())
    assert np.abs(surface.basis @ np.ones(patches.n_dofs) - 1.0).max() < 1e-14
    # two pairs of functions coincide on the element at each end of a corner
    assert np.bincount(np.diff(patches.indptr))[[7, 9]].tolist() == [8, 24]


def test_restriction_cuts_functions():
    whole = Pillow(12, 6)
    part, rest = whole.restrict(np.arange(8)), whole.restrict(np.arange(8, 72))
    assert part.n_elements + rest.n_elements == whole.n_elements
    assert part.n_coefficients + rest.n_coefficients > whole.n_coefficients
    c = random_field(whole, smooth=True)
    xi = np.array([0.3])
    joined = np.concatenate([p.sample(xi, xi) @ c[p.kept] for p in (part, rest)])
    np.testing.assert_array_equal(joined, whole.sample(xi, xi) @ c)


def test_fold_map_stretches_by_one_minus_z_kappa():
    curve = zigzag(2, 6.0, 1.0)
    x = np.random.default_rng(0).uniform([0, -1, -0.3], [18, 1, 0.3], (200, 3))
    step = 1e-6
    _, theta = curve.at(x[:, 0])
    kappa = (curve.at(x[:, 0] + step)[1] - theta) / step
    along = np.linalg.norm(curve.fold(x + np.array([step, 0, 0])) - curve.fold(x), axis=1) / step
    np.testing.assert_allclose(along, 1.0 - x[:, 2] * kappa, atol=1e-5)
    across = np.linalg.norm(curve.fold(x + np.array([0, 0, step])) - curve.fold(x), axis=1) / step
    np.testing.assert_allclose(across, 1.0, atol=1e-8)


def test_mid_curves_are_closed_forms():
    curve = zigzag(1, 6.0, 1.0)  # ends above its beginning, two radii up, running back
    end, angle = curve.at(np.array([12.0]))
    np.testing.assert_allclose(end, [[0.0, 2.0]], atol=1e-12)
    np.testing.assert_allclose(angle, np.pi)
    tiny = PlanarCurve((1.0,), (1e-300,)).at(np.array([0.5]))[0]
    np.testing.assert_allclose(tiny, [[0.5, 0.0]], atol=1e-300)
    spiral = roll(2.0, 1.0, 0.2)
    expected = 2 * np.pi * 2.0 * 1.0 + np.pi * 0.2 * 2.0**2
    assert abs(spiral.length / expected - 1.0) < 1e-12


def test_folding_keeps_the_volume():
    """Plain folds keep the volume of the flat bag (alternating arcs cancel)."""
    folded = accordion(64, 2)
    flat_surface = Pillow(64, 32)
    gap = 0.4 / 30
    flat, _ = fit(flat_surface, flattened(0.5 * gap), rectangle(1.0, 1.0))
    volumes = []
    for c in (folded.coefficients, flat):
        outer = sample(folded.patches(), c, QuadratureOrders()).outer
        volumes.append(outer.weights @ np.sum(outer.points * outer.normals, axis=1) / 3.0)
    assert abs(volumes[0] / volumes[1] - 1.0) < 0.02
    assert volumes[1] > 0.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Pillow(7, 4), "even"),
        (lambda: zigzag(2, 3.0, 1.0), r"panel > pi"),
        (lambda: accordion(16, 2, gap=2.5), "inside out"),
        (lambda: PlanarCurve((1.0,), (0.0, 1.0)), "curvature"),
    ],
)
def test_impossible_shapes_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
