"""Every broken or awkward file is answered by one line with a place, or mended with a note."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.mending.topology import edges_of
from cases.geometry.meshes.reading import read_facets
from cases.geometry.meshes.repair import repaired

from .awkward import AWKWARD, unfolded_deck
from .written import bag

pytestmark = pytest.mark.filterwarnings("error", "ignore:.*:DeprecationWarning:meshio")


def read_and_mended(path: Path) -> FacetMesh:
    """What a user's file becomes; errors name the file."""
    return repaired(read_facets(path))


def test_there_are_more_than_thirty() -> None:
    assert len(AWKWARD) >= 30
    assert sum(case.mended for case in AWKWARD.values()) >= 10


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_files(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    case = AWKWARD[name]
    path = case.written(tmp_path)
    capfd.readouterr()
    if case.mended:
        mesh = read_and_mended(path)
        assert re.search(case.answer, "\n".join(mesh.notes)), mesh.notes
        assert all(len(note.splitlines()) == 1 for note in mesh.notes)
        assert edges_of(mesh.triangles).counts.max() <= 2
        assert np.array_equal(np.unique(mesh.triangles), np.arange(len(mesh.points)))
    else:
        with pytest.raises(MeshError) as caught:
            read_and_mended(path)
        answer = str(caught.value)
        assert re.search(case.answer, answer), answer
        assert len(answer.splitlines()) == 1
        assert len(answer) < 400
        assert answer.isprintable()
        assert "cannot be read as" not in answer
    assert capfd.readouterr() == ("", "")


def test_missing_files_and_folders(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="no such file"):
        read_facets(tmp_path / "none.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(MeshError, match="a folder; name the file in it"):
        read_facets(tmp_path / "folder.stl")


def test_sizes_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = AWKWARD["inward"].written(tmp_path)
    monkeypatch.setattr("cases.geometry.meshes.faceting.MOST_TRIANGLES", 79)
    with pytest.raises(MeshError, match="80 triangles, 79 at most; decimate"):
        read_facets(path)
    monkeypatch.setattr("cases.geometry.meshes.reading.MOST_BYTES", 1000)
    with pytest.raises(MeshError, match=r"MiB, 0 at most; decimate it"):
        read_facets(path)


def test_the_unfolded_bag_is_the_reference(tmp_path: Path) -> None:
    path = tmp_path / "bag.k"
    path.write_text(unfolded_deck(bag()))
    mesh = read_and_mended(path)
    assert mesh.reference is not None
    assert np.array_equal(mesh.reference, 2 * mesh.points)
    assert "reference geometry of 42 of 42 nodes" in mesh.notes


def test_a_reader_that_fails_is_a_word_on_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = AWKWARD["inward"].written(tmp_path)

    def broken(data: bytes) -> None:
        raise RecursionError("too\ndeep")

    monkeypatch.setattr("cases.geometry.meshes.formats.stl.read", broken)
    with pytest.raises(
        MeshError, match=r"bag.stl: cannot be read as STL \(RecursionError: too deep"
    ):
        read_facets(path)
