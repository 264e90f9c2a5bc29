"""Settings of the whole suite, made before numpy and numba load; which tests share a process."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# one BLAS thread: small matrices, and kernels bring their own threads
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

ROOT = Path(__file__).resolve().parent
# files whose kernels take longest to compile: in one process, so that none is compiled twice
COMPRESSION = ("test_compression.py", "test_compressed_layer.py", "test_schwarz.py")
# the other process meanwhile compiles other kernels: what needs those of hbem comes last
LAST = ("hbem", "cases/kinds", "stress", "test_readme.py")


def _turn(path: Path) -> int:
    if path.name in COMPRESSION:
        return 0
    return 2 if path.relative_to(ROOT).as_posix().startswith(LAST) else 1


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of a file stay together, for its fixtures; turns spread the compiling."""
    items.sort(key=lambda item: _turn(item.path))
    for item in items:
        group = "compression" if _turn(item.path) == 0 else str(item.path)
        item.add_marker(pytest.mark.xdist_group(group))
