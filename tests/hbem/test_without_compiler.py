"""Every kernel also runs as plain Python, with the same result; there indices are checked."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from cases.benchmarks.meshes.raw_bodies import raw_sphere
from cases.geometry.bodies import fitted, sphere
from hbem.layers.double_layer import double_layer
from hbem.layers.single_layer import single_layer
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.subdivision import divide

ROOT = Path(__file__).resolve().parents[2]
TINY = QuadratureOrders(
    outer=1,
    near_offset=2.0,
    near_slope=0.5,
    radial=1,
    angular=1,
    double_offset=2.0,
    double_slope=0.0,
)


def triangles():
    """Six triangles, a few of which are bent and bisected."""
    raw = raw_sphere(5)
    bent = replace(raw, shape=lambda x: np.where(x[..., 2:] > 0.2, raw.shape(x), x))
    return bent.patches()


def matrices():
    """Both layers on the smallest bodies."""
    bodies = sphere(3, 4), fitted(sphere(3, 4)), triangles()
    made = [single_layer(b, b.coefficients, TINY) for b in bodies]
    return [v.dense() for v in made] + [double_layer(made[-1].surface, TINY).dense()]


def plain_python():
    """Print the matrices; run without the compiler and with checked indices."""
    for matrix in matrices():
        np.savetxt(sys.stdout, matrix)


def test_plain_python_with_checked_indices():
    code = "import checked_indices; checked_indices.install()\n"
    code += "import test_without_compiler; test_without_compiler.plain_python()"
    path = os.pathsep.join([str(ROOT), str(Path(__file__).parent)])
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path},
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found = np.array([float(word) for word in done.stdout.split()])
    expected = np.concatenate([m.ravel() for m in matrices()])
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_triangles_are_divided_differently_in_every_contraction():
    surface = single_layer(triangles(), triangles().coefficients, TINY).surface
    pieces = [np.diff(divide(s.control).indptr) for s in (surface, *surface.rotated)]
    assert np.any(pieces[0] != pieces[1])
    assert np.any(pieces[0] == 1)


@pytest.mark.parametrize("key", [-1, 3, (0, -1), (0, 2), slice(-2, 2), slice(1, 4)])
def test_indices_beyond_an_array_are_refused(key):
    array = run_path(str(Path(__file__).parent / "checked_indices.py"))["CheckedArray"]
    checked = np.zeros((3, 2)).view(array)
    assert checked[2, 1] == 0.0
    with pytest.raises(IndexError):
        checked[key]
