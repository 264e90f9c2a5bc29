"""Every kernel also runs as plain Python, with the same result."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from cases.geometry.bodies import fitted, sphere
from hbem.layers.single_layer import single_layer
from hbem.surfaces.quadrature import QuadratureOrders

ROOT = Path(__file__).resolve().parents[2]
CODE = """
import sys
import numpy as np
from cases.geometry.bodies import fitted, sphere
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.layers.single_layer import single_layer
tiny = QuadratureOrders(outer=1, near_offset=2.0, near_slope=0.5, radial=1, angular=1)
for body in (sphere(3, 4), fitted(sphere(3, 4))):
    np.savetxt(sys.stdout, single_layer(body, body.coefficients, tiny).dense())
"""


def test_plain_python():
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", CODE]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment, timeout=60, check=True
    )
    tiny = QuadratureOrders(outer=1, near_offset=2.0, near_slope=0.5, radial=1, angular=1)
    found = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    matrices = [
        single_layer(body, body.coefficients, tiny).dense()
        for body in (sphere(3, 4), fitted(sphere(3, 4)))
    ]
    expected = np.concatenate(matrices)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
