"""Compressed against dense: every operator keeps the tolerance that was asked for."""

import logging

import numpy as np
import pytest

from cases.benchmarks.honesty import clouds
from hbem.compression import operator as compressed
from hbem.compression.h2matrix import h2matrix
from hbem.compression.hmatrix import hmatrix
from hbem.compression.point_kernel import probe_densities

METHODS = {"aca": hmatrix, "h2": h2matrix}
TOLERANCES = (
    1e-3,
    1e-6,
    *(pytest.param(t, marks=pytest.mark.slow) for t in (1e-2, 1e-4, 1e-8)),
)


@pytest.fixture(scope="module", params=list(clouds.CLOUDS))
def cloud(request):
    """A cloud with its dense single and double layer."""
    points = clouds.CLOUDS[request.param]
    normals = clouds.normals(request.param, points)
    return points, normals, clouds.dense(points), clouds.dense(points, normals)


def errors(operator, matrix, seed=5):
    """Relative errors of the whole product for random and constant densities.

    The last column is a constant of random direction, which the package does not try.
    """
    n = matrix.shape[0] // 3
    x = probe_densities(n, seed).reshape(3 * n, -1)
    x = np.c_[x, x[:, -3:] @ np.random.default_rng(seed).standard_normal(3)]
    exact = matrix @ x
    size = np.linalg.norm(exact, axis=0)
    return np.linalg.norm(operator @ x - exact, axis=0) / np.where(size > 0.0, size, 1.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_single_layer(cloud, method, tolerance):
    points, _, matrix, _ = cloud
    operator = METHODS[method](points, tolerance, leaf=32)
    assert errors(operator, matrix).max() <= tolerance
    assert operator.statistics.achieved <= tolerance
    assert operator.statistics.method == method


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_double_layer(cloud, method, tolerance):
    points, normals, _, matrix = cloud
    operator = METHODS[method](points, tolerance, normals=normals, leaf=32)
    assert errors(operator, matrix).max() <= tolerance
    assert operator.statistics.achieved <= tolerance


@pytest.mark.parametrize("method", METHODS)
def test_measured_error_is_the_true_one(method, monkeypatch):
    """All rows of a small cloud; fewer of a large one estimate it."""
    points = clouds.CLOUDS["stack"]
    operator = METHODS[method](points, 1e-4)
    true = errors(operator, clouds.dense(points), seed=0)[:-1]
    assert operator.statistics.achieved == pytest.approx(true.max(), rel=1e-6)
    monkeypatch.setattr(compressed, "TEST_PAIRS", 0)
    sampled = operator.relative_error(probe_densities(points.shape[0], 0))
    np.testing.assert_allclose(sampled, true, rtol=0.7)


@pytest.mark.parametrize("method", METHODS)
def test_units_do_not_matter(method):
    """A body a thousand times larger, far from the origin."""
    points = clouds.CLOUDS["fold"]
    operator = METHODS[method](1e3 * points + 1e4, 1e-4)
    assert errors(operator, 1e-3 * clouds.dense(points)).max() <= 1e-4


@pytest.mark.parametrize("method", METHODS)
def test_several_vectors_at_once(method):
    points = clouds.CLOUDS["sphere"]
    operator = METHODS[method](points, 1e-6)
    x = np.random.default_rng(0).standard_normal((operator.shape[1], 5))
    one_by_one = np.stack([operator @ column for column in x.T], axis=1)
    np.testing.assert_allclose(operator @ x, one_by_one, rtol=0, atol=1e-12 * np.abs(x).max() * 1e3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", [1e39, 1e-44, 1e300, 0.0])
def test_densities_of_any_size(method, size):
    """Single precision knows nothing beyond 1e38."""
    points = clouds.CLOUDS["sphere"][:300]
    operator = METHODS[method](points, 1e-3)
    x = np.random.default_rng(0).standard_normal((900, 2))
    found, expected = operator @ (size * x) / (size or 1.0), operator @ (x * (size > 0.0))
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(operator @ x).max())


@pytest.mark.parametrize("method", METHODS)
def test_points_of_a_graded_mesh(method):
    """Spacings from 5e-8 to 1: neighbours differ by less than centring them would round."""
    points = clouds.graded(20, 5e-8)
    upward = np.tile([0.0, 0.0, 1.0], (points.shape[0], 1))
    for normals in (None, upward):
        matrix = clouds.dense(points, normals)
        for tolerance in (1e-3, 1e-6):
            operator = METHODS[method](points, tolerance, normals=normals, leaf=32)
            assert errors(operator, matrix).max() <= tolerance
            assert operator.statistics.achieved <= tolerance


def test_what_rounding_leaves_of_a_double_layer_is_measured(caplog):
    """On an oblique plane ``r . n`` is rounding, which at a spacing of 1e-5 is not small."""
    line = np.append(0.0, np.geomspace(1.2e-5, 1.0, 19))
    x, y = (g.ravel() for g in np.meshgrid(line, line))
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    points, normals = np.c_[x, y, 0.0 * x] @ turn.T, np.tile(turn[:, 2], (x.size, 1))
    with caplog.at_level(logging.WARNING):
        operator = hmatrix(points, 1e-6, normals=normals)
    true = errors(operator, clouds.dense(points, normals)).max()
    assert 1e-6 < true < 10.0 * operator.statistics.achieved
    assert "rounding of the points and normals given leaves an error" in caplog.text


@pytest.mark.parametrize("method", METHODS)
def test_transposed_product(method):
    points = clouds.CLOUDS["sphere"][:300]
    operator, exact = METHODS[method](points, 1e-6), clouds.dense(points)
    x = np.random.default_rng(0).standard_normal((900, 2))
    np.testing.assert_allclose(operator.T @ x, exact.T @ x, atol=1e-5 * np.abs(exact @ x).max())
    double = METHODS[method](points, 1e-3, normals=points)
    with pytest.raises(NotImplementedError, match="normals at the targets"):
        _ = double.T @ x
    with pytest.raises(ValueError, match="complex densities"):
        _ = operator @ (1j * x)


@pytest.mark.parametrize("method", METHODS)
def test_same_build_same_numbers(method):
    points = clouds.CLOUDS["stack"]
    x = np.random.default_rng(0).standard_normal(3 * points.shape[0])
    first, second = (METHODS[method](points, 1e-3) @ x for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("method", METHODS)
def test_threads_do_not_change_the_result(method):
    numba = pytest.importorskip("numba")
    points = clouds.CLOUDS["stack"]
    x = np.random.default_rng(0).standard_normal(3 * points.shape[0])
    threads = numba.get_num_threads()
    several = METHODS[method](points, 1e-3) @ x
    try:
        numba.set_num_threads(1)
        one = METHODS[method](points, 1e-3) @ x
    finally:
        numba.set_num_threads(threads)
    np.testing.assert_array_equal(one, several)


@pytest.mark.parametrize("method", METHODS)
def test_indexing_explains(method):
    operator = METHODS[method](clouds.CLOUDS["line"][:200], 1e-3)
    with pytest.raises(TypeError, match="exact_rows"):
        operator[0, 0]
    with pytest.raises(TypeError, match="no entries to index"):
        operator[:5]


@pytest.mark.parametrize("method", METHODS)
def test_repr_tells_error_ranks_and_bytes(method):
    text = repr(METHODS[method](clouds.CLOUDS["sphere"], 1e-3))
    for word in ("requested 1.0e-03", "rank", "MB", "of dense", "s build"):
        assert word in text


def test_zero_double_layer_has_no_rank():
    """On one plane r . n = 0 everywhere."""
    points = clouds.sheets(30, (0.0,))
    operator = hmatrix(points, 1e-4, normals=np.tile([0.0, 0.0, 1.0], (900, 1)))
    assert operator.statistics.rank_max == 0
    assert np.abs(operator @ np.ones(2700)).max() == 0.0


def test_rows_of_a_fold_that_start_at_zero():
    """Half of the targets of an L see nothing of a coplanar cluster: not a converged block."""
    points = clouds.fold(40)
    normals = clouds.normals("fold", points)
    operator = hmatrix(points, 1e-5, normals=normals)
    x = probe_densities(points.shape[0], 1)
    assert operator.relative_error(x, seed=2).max() <= 1e-5


class TestStress:
    """Degenerate clouds stay correct."""

    @pytest.mark.parametrize("method", METHODS)
    def test_clusters_of_identical_points(self, method):
        few = np.random.default_rng(0).random((8, 3))
        points = np.repeat(few, 100, axis=0)
        operator = METHODS[method](points, 1e-4)
        assert errors(operator, clouds.dense(points)).max() <= 1e-4

    @pytest.mark.parametrize("method", METHODS)
    def test_all_points_identical(self, method):
        operator = METHODS[method](np.ones((300, 3)), 1e-4)
        assert np.abs(operator @ np.ones(900)).max() == 0.0

    @pytest.mark.parametrize("method", METHODS)
    def test_one_far_outlier(self, method):
        points = np.concatenate([clouds.sphere(800), [[1e6, 0.0, 0.0]]])
        operator = METHODS[method](points, 1e-4)
        assert errors(operator, clouds.dense(points)).max() <= 1e-4

    @pytest.mark.parametrize("method", METHODS)
    def test_tolerance_below_rounding_is_summed_exactly(self, method, caplog):
        points = clouds.CLOUDS["torus"]
        with caplog.at_level(logging.WARNING):
            operator = METHODS[method](points, 1e-12)
        assert operator.statistics.method == "direct"
        assert "exact sums" in caplog.text
        assert errors(operator, clouds.dense(points)).max() <= 1e-12

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("n", [1, 2, 30])
    def test_fewer_points_than_a_leaf(self, method, n):
        points = clouds.sphere(n)
        operator = METHODS[method](points, 1e-6)
        matrix = clouds.dense(points) if n > 1 else np.zeros((3, 3))
        assert errors(operator, matrix).max() <= 1e-6

    @pytest.mark.parametrize("method", METHODS)
    def test_forecast_over_memory_is_refused_with_numbers(self, method):
        with pytest.raises(MemoryError, match=r"GB, 0\.00 GB are allowed.*dense"):
            METHODS[method](clouds.sphere(20000), 1e-6, memory=1e6)

    def test_a_block_that_misses_is_built_again(self, monkeypatch, caplog):
        """Sabotage: a sloppy recompression is noticed, repeated, and at last replaced."""
        from hbem.compression import cross_approximation as aca

        monkeypatch.setitem(aca.KEPT, "points", 2e3)
        with caplog.at_level(logging.WARNING):
            operator = hmatrix(clouds.sphere(3000), 1e-4)
        assert "above the tolerance" in caplog.text
        assert operator.statistics.method == "direct"
        assert operator.statistics.achieved <= 1e-4

    @pytest.mark.parametrize("method", METHODS)
    def test_wrong_arguments(self, method):
        build = METHODS[method]
        with pytest.raises(ValueError, match="finite"):
            build(np.full((10, 3), np.nan), 1e-3)
        with pytest.raises(ValueError, match="complex"):
            build(np.ones((10, 3)) * 1j, 1e-3)
        with pytest.raises(ValueError, match="beyond double precision"):
            build(1e200 * np.eye(3), 1e-3)
        with pytest.raises(ValueError, match="tolerance"):
            build(np.ones((10, 3)), 2.0)
        with pytest.raises(ValueError, match=r"\(n, 3\)"):
            build(np.ones((10, 2)), 1e-3)
        with pytest.raises(ValueError, match="normals"):
            build(np.ones((10, 3)), 1e-3, normals=np.ones((4, 3)))
