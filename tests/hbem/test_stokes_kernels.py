"""Every kernel gives the Stokeslet and the stresslet of their formulas, compiled or not."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hbem import _stokes_kernels as owner
from hbem.compression import _cluster_sum_kernels, _near_block_kernels
from hbem.compression._cross_approximation_kernels import SAMPLES, cross
from hbem.flows import _field_kernels
from hbem.layers import _dense_block_kernels, _dense_layer_kernels
from hbem.layers import _double_layer_kernels as double_layer
from hbem.layers import _point_sum_kernels as point_sums
from hbem.near._patch_lane_kernels import LANES
from hbem.near._vector_kernels import kernel_values
from hbem.surfaces.quadrature import gauss_tables

SIX = np.array([0, 1, 2, 4, 5, 8])  # components 00 01 02 11 12 22 of a 3x3 matrix
TINY = 1e-24
ROOT = Path(__file__).resolve().parents[2]


def kernels(x, y, normals=None):
    """The formulas: ``(n_x, n_y, 3, 3)``, zero at coincident points."""
    r = x[:, None] - y[None]
    square = np.sum(r * r, axis=-1)
    with np.errstate(all="ignore"):
        d = np.sqrt(square)[..., None, None]
        rr = r[..., :, None] * r[..., None, :]
        if normals is None:
            out = (np.eye(3) / d + rr / d**3) / (8.0 * np.pi)
        else:
            flux = np.sum(r * normals, axis=-1)[..., None, None]
            out = 3.0 / (4.0 * np.pi) * rr * flux / d**5
    return np.where(d == 0.0, 0.0, out)


def six(matrices):
    return matrices.reshape(*matrices.shape[:-2], 9)[..., SIX]


def agree(found, expected, tolerance=1e-14):
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=tolerance * np.abs(expected).max())


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_scalars(rng, kind):
    r, n = rng.normal(size=(2, 3)).astype(kind)
    a, b = owner.stokeslet(kind(2.0), *r, kind(0.0))
    c = owner.stresslet(kind(2.0), *r, *n, kind(0.0))
    x, y = r.astype(float)[None], np.zeros((1, 3))
    rr, small = np.outer(x, x), 1e-14 if kind is np.float64 else 1e-6
    agree(a * np.eye(3) + b * rr, 16.0 * np.pi * kernels(x, y)[0, 0], small)
    agree(c * rr, 16.0 * np.pi * kernels(x, y, n.astype(float)[None])[0, 0], small)
    assert owner.stokeslet(1.0, 1e-13, 0.0, 0.0, TINY) == (0.0, 0.0)
    assert owner.stresslet(1.0, 1e-13, 0.0, 0.0, 1.0, 0.0, 0.0, TINY) == 0.0


@pytest.mark.parametrize("layer", ["single", "double", "lone source"])
def test_kernel_line(rng, layer):
    x, y, n = rng.normal(size=3), rng.normal(size=(7, 3)), rng.normal(size=(7, 3))
    y[2] = x
    out = np.empty((3, 21))
    given = {"single": np.empty((3, 0)), "double": n.T, "lone source": -n[:1].T}[layer]
    owner.kernel_line(owner.OVER_8_PI, x, np.ascontiguousarray(y.T), given.copy(), TINY, out)
    if layer == "lone source":
        expected = kernels(y, x[None], n[:1])[:, 0]
    else:
        expected = kernels(x[None], y, n if layer == "double" else None)[0]
    agree(out.reshape(3, 3, 7), expected.transpose(1, 2, 0))


def test_point_sums(rng):
    x, y, f = rng.normal(size=(64, 3)), rng.normal(size=(20, 3)), rng.normal(size=(20, 3, 2))
    y[4] = x[9]
    expected = np.einsum("xyik,ykc->cix", kernels(x, y), f)
    blocks, out = x.T.reshape(1, 3, 64).copy(), np.empty((1, 3, 64))
    point_sums.single_layer_sums((0, 1), blocks, y, f[..., 0].copy(), TINY, out)
    agree(out[0], expected[0])
    out, strengths = np.empty((1, 2, 192)), f.transpose(2, 0, 1).reshape(1, 2, 60).copy()
    point_sums.single_layer_block_sums((0, 1), blocks, y[None], strengths, TINY, out)
    agree(out.reshape(2, 3, 64), expected)


def test_dense_single_layer(rng):
    x, y, w = rng.normal(size=(2, 5, 3)), rng.normal(size=(2, 4, 3)), rng.random((2, 4))
    x[1, 0] = y[1, 0]
    targets, indptr, rows = x.transpose(0, 2, 1).copy(), np.array([0, 4, 8]), np.arange(8)
    each_source, each_target = np.tile(np.eye(4), (2, 1)), np.tile(np.eye(5)[:4], (2, 1))
    expected = six(kernels(x.reshape(-1, 3), y.reshape(-1, 3))) * w.reshape(-1)[:, None]
    columns = np.empty((2, 8, 30))
    _dense_layer_kernels.source_columns(
        (0, 2), targets, y, w, each_source, indptr, rows, TINY, columns
    )
    agree(columns.reshape(2, 8, 6, 5).transpose(0, 3, 1, 2).reshape(10, 8, 6), expected)
    block = np.zeros((8, 8, 6))
    _dense_block_kernels.plain_block(
        np.arange(2), targets, np.ones((2, 5)), each_target, y, w, each_source, indptr, rows,
        False, TINY, block,
    )  # fmt: skip
    agree(block, expected.reshape(2, 5, 8, 6)[:, :4].reshape(8, 8, 6))


def test_double_layer_sums(rng):
    x, y, n = rng.normal(size=(64, 3)), rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    f = rng.normal(size=(6, 2, 3))
    y[4] = x[9]
    expected, blocks = kernels(x, y, n), x.T.reshape(1, 3, 64).copy()
    out = np.empty((1, 2, 3, 64))
    double_layer.double_sums((0, 1), blocks, y, n, f, TINY, out)
    agree(out[0], np.einsum("xyik,yck->cix", expected, f))
    out = np.empty((1, 6, 64))
    double_layer.kernel_sums((0, 1), blocks, y, n, TINY, out)
    agree(out[0], six(expected.sum(axis=1)).T)
    out = np.empty((6, 6, 64))
    double_layer.double_matrix((0, 6), blocks[0], y, n, TINY, out)
    agree(out, six(expected).transpose(2, 1, 0))


@pytest.mark.parametrize("double", [False, True])
def test_near_block(rng, double):
    points, weights = rng.normal(size=(50, 3)), rng.random(50)
    normals = rng.normal(size=(50, 3)) if double else None
    given = normals.T.copy() if double else np.empty((3, 0))
    t, s = np.arange(30), np.arange(30, 50)
    points[30] = points[0]
    out = np.empty((6, 20, 30))
    _near_block_kernels.one_block(
        points.T.copy(), given, TINY, t, s, t, s, np.arange(51), np.arange(50), weights,
        np.empty(50, np.int32), out,
    )  # fmt: skip
    expected = six(kernels(points[t], points[s], normals[s] if double else None))
    expected *= weights[t][:, None, None] * weights[s][:, None]
    agree(out, expected.transpose(2, 1, 0))


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("double", [False, True])
def test_cluster_sums(rng, double, kind):
    x, y, f = rng.normal(size=(10, 3)), rng.normal(size=(8, 3)), rng.normal(size=(1, 3, 8))
    n = rng.normal(size=(8, 3)) if double else None
    out, ptr = np.zeros((1, 3, 10)), np.array([0, 1])
    _cluster_sum_kernels.cluster_sums(
        (0, 1), x.T.copy(), 10 * ptr, y.T.copy(), 8 * ptr,
        n.T.copy() if double else np.empty((3, 0)), ptr, np.array([0]), f.astype(kind), TINY, out,
    )  # fmt: skip
    expected = np.einsum("xyik,cky->cix", kernels(x, y, n), f)
    agree(out, expected, 1e-14 if kind is np.float64 else 1e-5)


@pytest.mark.filterwarnings("ignore:overflow encountered")  # its random numbers wrap around
@pytest.mark.parametrize("double", [False, True])
def test_cross_approximation(rng, double):
    x, y = rng.random((30, 3)), np.add(rng.random((20, 3)), [5.0, 0.0, 0.0])
    n = rng.normal(size=(20, 3)) if double else None
    u, v = np.empty((63, 90)), np.empty((63, 60))
    rank = cross(
        x.T.copy(), y.T.copy(), n.T.copy() if double else np.empty((3, 0)), TINY, 1e-7, 60, 5,
        u, v, np.empty((SAMPLES, 3, 60)), np.zeros((7, 90)),
    )  # fmt: skip
    assert 0 < rank < 60
    expected = kernels(x, y, n).transpose(2, 0, 3, 1).reshape(90, 60)
    agree(u[:rank].T @ v[:rank], expected, 1e-6)


@pytest.mark.parametrize("layer", [0, 1])
@pytest.mark.parametrize("degree", [2, 3, 4])
def test_fused_near_rule(rng, degree, layer):
    """The near rule keeps a form of its own for the single layer: the surface element is inside."""
    target, sigma = rng.normal(size=(3, LANES)), rng.uniform(-1.0, 1.0, LANES)
    row, w = rng.normal(size=(2, 3, degree + 1, LANES)), rng.random((2, LANES))
    powers = sigma ** np.arange(degree + 1)[:, None]
    slopes = np.arange(1, degree + 1)[:, None] * powers[:-1]
    y, along_t = np.einsum("kcix,ix->kxc", row, powers)
    normal = np.cross(np.einsum("cix,ix->xc", row[0, :, 1:], slopes), along_t)
    out, place = np.empty(6 * LANES), np.empty(9 * LANES)
    kernel_values(
        degree, layer, target.ravel(), row.ravel(), sigma, w[0], w[1], TINY, place, out
    )  # fmt: skip
    at = np.arange(LANES)
    expected = six(kernels(target.T, y, normal if layer == 1 else None)[at, at])
    if layer == 0:
        expected *= np.linalg.norm(normal, axis=1)[:, None]
    agree(out.reshape(6, LANES).T, expected * (w[0] * w[1])[:, None])


@pytest.mark.parametrize("factor", [0.0, -1.5])
def test_fields(rng, factor):
    """Velocity from the formulas; the stress from its derivatives, taken by complex steps."""
    x, y, n = rng.normal(size=(3, 3)), rng.normal(size=(2, 4, 3)), rng.normal(size=(2, 4, 3))
    values, walls, out = rng.normal(size=(2, 4, 6)), rng.normal(size=(3, 3)), np.empty((3, 11))
    none, empty = np.zeros(4, np.int64), np.empty(0, np.int64)
    _field_kernels.fields(
        (0, 1), x, none, empty, np.empty((0, 5)), np.empty((2, 4)), np.empty((2, 3, 3, 3)),
        np.empty((2, 3, 3, 6)), y, n, values, (6.0, 2.0), factor, *gauss_tables(), walls, out,
    )  # fmt: skip
    y, n, values = y.reshape(-1, 3), n.reshape(-1, 3), values.reshape(-1, 6)
    force = values[:, :3] * np.linalg.norm(n, axis=1)[:, None]
    moment = factor * (values[:, 3:] - walls[:, None])

    def velocity(x):
        single = np.einsum("xyik,yk->xi", kernels(x, y), force)
        return single + np.einsum("xyik,xyk->xi", kernels(x, y, n), moment)

    small = 1e-150
    gradient = [velocity(x + 1j * small * step).imag / small for step in np.eye(3)]
    gradient = np.stack(gradient, axis=-1)
    agree(out[:, :3], velocity(x))
    stress = gradient + gradient.transpose(0, 2, 1) - out[:, 3, None, None] * np.eye(3)
    agree(out[:, 4:10], six(stress))
    r = x[:, None] - y
    solid = np.sum(r * n, axis=-1) / np.sum(r * r, axis=-1) ** 1.5
    agree(out[:, 10], -solid.sum(axis=1) / (4.0 * np.pi))


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="this is the run without a compiler")
def test_without_compiler():
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, env=environment, timeout=120
    )
    assert done.returncode == 0, done.stdout
