"""Settings of the whole suite, made before numpy and numba load; which tests share a process."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# one BLAS thread: small matrices, and kernels bring their own threads
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

# files whose kernels take longest to compile: in one process, so that none is compiled twice
COMPRESSION = (
    "test_compression.py",
    "test_compressed_layer.py",
    "test_schwarz.py",
    "test_stokes_flow.py",
)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of a file stay together, for its fixtures; the longest group comes first."""
    items.sort(key=lambda item: item.path.name not in COMPRESSION)
    for item in items:
        path: Path = item.path
        group = "compression" if path.name in COMPRESSION else str(path)
        item.add_marker(pytest.mark.xdist_group(group))
