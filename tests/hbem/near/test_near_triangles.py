"""Near rules of triangles: bisected ones, those contracted at another vertex, and numberings."""

from dataclasses import replace

import numpy as np
import pytest

from cases.benchmarks.meshes.raw_bodies import RawBody, raw_ellipsoid
from hbem._threads_kernels import limited
from hbem.flows.mesh_share import broken
from hbem.layers.double_layer import double_layer
from hbem.layers.single_layer import single_layer
from hbem.near import near_rules
from hbem.near.closest_point import outer_pairs
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.subdivision import divide
from hbem.surfaces.surface_points import sample

EMPTY = np.empty


@pytest.fixture
def poison(monkeypatch, body):
    """Fresh memory that holds NaN, or integers that are no index."""
    layers(*body)  # the compiler must know `numpy.empty`

    def empty(shape, dtype=float, **options):
        made = EMPTY(shape, dtype, **options)
        kind = made.dtype.kind
        if kind in "fi":
            made.fill(np.nan if kind == "f" else np.iinfo(made.dtype).min)
        return made

    monkeypatch.setattr(np, "empty", empty)
    # and what compiled code finds on the heap
    for size in (8, 64, 512, 4096, 32768) * 4:
        np.full(size, np.nan)


@pytest.fixture(scope="module", params=[2, 3])
def body(request):
    """96 triangles; some are bisected in one contraction and not in another."""
    raw = raw_ellipsoid(50, 0.35)
    patches = raw.patches(degree=request.param)
    surface = sample(patches, patches.coefficients, QuadratureOrders())
    pieces = [np.diff(divide(s.control).indptr) for s in (surface, *surface.rotated)]
    assert np.any(pieces[0] != pieces[1])
    return raw, request.param


def layers(raw, degree):
    patches = raw.patches(degree=degree)
    single = single_layer(patches, patches.coefficients, QuadratureOrders(), storage="dense")
    return single.dense(), double_layer(single.surface, QuadratureOrders()).dense()


def test_repeats_on_poisoned_memory(body, poison):
    first, second = layers(*body), layers(*body)
    for a, b in zip(first, second, strict=True):
        assert np.all(np.isfinite(a))
        np.testing.assert_array_equal(a, b)


def renumbered(raw, order, roll):
    turned = np.array([np.roll([0, 1, 2], r) for r in roll])[:, :, None]
    triangles = np.take_along_axis(raw.triangles, turned[:, :, 0], axis=1)
    corners = np.take_along_axis(raw.corners, turned, axis=1)
    return RawBody(triangles[order], corners[order], raw.shape, raw.normal)


@pytest.mark.parametrize("rolled", [False, True])
def test_numbering_does_not_matter(body, poison, rolled):
    """Order of elements: rounding. Contraction: the outer rule, measured 6e-4 and 8e-3."""
    raw, degree = body
    random = np.random.default_rng(3)
    n = len(raw.triangles)
    roll = random.integers(0, 3, n) if rolled else np.zeros(n, int)
    other = renumbered(raw, random.permutation(n), roll)
    # with linear densities function a is vertex a in both
    for a, b, bound in zip(layers(raw, degree), layers(other, degree), (1e-3, 1e-2), strict=True):
        assert np.abs(a - b).max() < (bound if rolled else 1e-11) * np.abs(a).max()


def test_all_indices_are_of_the_tables_they_enter(body, monkeypatch):
    """Pieces, elements and points of every call of the kernels, in every contraction."""
    raw, degree = body
    patches = raw.patches(degree=degree)
    surface = sample(patches, patches.coefficients, QuadratureOrders())
    pairs = outer_pairs(surface, QuadratureOrders(), slice(0, 90))
    calls, moments = [], near_rules.kernels.near_moments

    def checked(span, form, *rest):
        points, point_of, elements, found, boxes, counts, _, ordered = rest[:8]
        patches, control, collapsed = rest[9:12]
        assert elements.size == point_of.size == len(found) == len(boxes) == len(counts)
        assert elements.min() >= 0
        assert elements.max() < len(patches) == len(control) == len(collapsed)
        assert point_of.min() >= 0
        assert point_of.max() < len(points)
        np.testing.assert_array_equal(np.sort(ordered), np.arange(elements.size))
        st, low, high = found[:, :2], boxes[:, ::2], boxes[:, 1::2]
        assert np.all((low - 1e-12 <= st) & (st <= high + 1e-12))
        calls.append((boxes, patches))
        moments(span, form, *rest)

    monkeypatch.setattr(near_rules.kernels, "near_moments", checked)
    with limited(1):
        near_rules.near_moments(surface, pairs, QuadratureOrders())
    assert len(calls) == 3
    for boxes, patches in calls[1:]:
        assert not np.array_equal(patches, surface.shapes.power_coefficients)
        np.testing.assert_array_equal(boxes, np.tile([0.0, 1.0, 0.0, 1.0], (len(boxes), 1)))


def test_contractions_agree(body, monkeypatch):
    """Moments of whole triangles, contracted at any vertex, are the same integrals."""
    raw, degree = body
    patches = raw.patches(degree=degree)
    surface = sample(patches, patches.coefficients, QuadratureOrders())
    pairs = outer_pairs(surface, QuadratureOrders(), slice(0, 90))
    finest = replace(QuadratureOrders.fine(), near_offset=16.0, near_slope=4.5)
    # of the functions that triangles have, in the larger space too; a contracted square has more
    spaces = [replace(surface, patches=p) for p in (surface.patches, broken(surface))]
    rotated = [near_rules.near_moments(s, pairs, finest) for s in spaces]
    monkeypatch.setattr(near_rules, "_vertices", lambda s, p: np.zeros(p.n_pairs, np.int64))
    for space, found in zip(spaces, rotated, strict=True):
        plain = near_rules.near_moments(space, pairs, finest)
        difference = space.patches.extraction[:6] @ (found - plain)
        assert np.abs(difference).max() < 1e-7 * np.abs(plain).max()
