"""Files cut short and bytes changed: no error but a word on the file, no triangle silently gone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.reading import read_facets
from cases.geometry.meshes.repair import repaired

from .written import WRITERS, bag, corners

CASES = 12
TYPED = np.frombuffer(b"0123456789.-e \n", np.uint8)


def answer(path: Path, *, mend: bool) -> FacetMesh | str:
    """The mesh, or the word on the file; no other error may come."""
    try:
        return repaired(read_facets(path)) if mend else read_facets(path)
    except MeshError as error:
        return str(error)


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_files_cut_short(form: str, tmp_path: Path) -> None:
    """Seen, or noted; a row-by-row text cut between rows (OBJ, Abaqus) cannot be told."""
    ending, write, _ = WRITERS[form]
    path, rng = tmp_path / f"bag{ending}", np.random.default_rng(len(form))
    write(bag(), path)
    whole = path.read_bytes()
    wanted = corners(read_facets(path))
    refused = 0
    for stop in rng.integers(1, len(whole.rstrip()), CASES).tolist():
        path.write_bytes(whole[:stop])
        found = answer(path, mend=False)
        if isinstance(found, str):
            refused += 1
            assert "cannot be read as" not in found, (stop, found)
            continue
        noted = any("nothing tells whether the file is whole" in note for note in found.notes)
        between = ending in (".obj", ".inp") and whole[:stop].endswith(b"\n")
        assert noted or between or np.array_equal(corners(found), wanted), stop
    assert refused >= CASES // 3


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_bytes_changed(form: str, tmp_path: Path) -> None:
    """Any byte, and in every second case what a keyboard could have put there."""
    ending, write, _ = WRITERS[form]
    path, rng = tmp_path / f"bag{ending}", np.random.default_rng(len(form))
    write(bag(), path)
    whole = np.frombuffer(path.read_bytes(), np.uint8)
    for case in range(CASES):
        data, at = whole.copy(), rng.integers(0, len(whole), 2)
        data[at] = rng.choice(TYPED, 2) if case % 2 else rng.integers(0, 256, 2)
        path.write_bytes(data.tobytes())
        found = answer(path, mend=True)
        if isinstance(found, str):
            assert found.isprintable()
            assert "cannot be read as" not in found, (case, at, found)
