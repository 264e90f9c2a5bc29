"""One bag with two groups through all formats: the same points, triangles and groups."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cases.geometry.meshes.reading import FORMATS, read_facets
from cases.geometry.meshes.repair import repaired

from .written import WRITERS, bag, corners


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_bag_comes_back(form: str, tmp_path: Path) -> None:
    ending, write, inlet = WRITERS[form]
    given, path = bag(), tmp_path / f"bag{ending}"
    write(given, path)
    facets = read_facets(path)
    assert np.array_equal(corners(facets), corners(given))
    mended = repaired(facets)
    assert len(mended.points) == len(given.points)
    assert np.array_equal(corners(mended), corners(given))
    if inlet is not None:
        assert np.array_equal(corners(mended, inlet), corners(given, "inlet"))
        assert len(mended.groups) >= 2


@pytest.mark.parametrize("form", [form for form in WRITERS if "binary" not in form])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_lines_may_end_as_on_windows(form: str, tmp_path: Path) -> None:
    ending, write, inlet = WRITERS[form]
    given, path = bag(), tmp_path / f"bag{ending}"
    write(given, path)
    data = path.read_bytes()
    path.write_bytes(data.replace(b"\n", b"\r\n"))
    facets = read_facets(path)
    assert np.array_equal(corners(facets), corners(given))
    if inlet is not None:
        assert np.array_equal(corners(facets, inlet), corners(given, "inlet"))


def test_every_ending_has_a_round_trip() -> None:
    tried = {ending for ending, _, _ in WRITERS.values()}
    readers = {FORMATS[ending] for ending in tried}
    assert readers == set(FORMATS.values())
