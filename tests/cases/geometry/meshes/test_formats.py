"""What each format can say beside plain triangles."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from cases.geometry.meshes.facet_mesh import FacetMesh, MeshError
from cases.geometry.meshes.faceting import faceted
from cases.geometry.meshes.formats.cells import CellMesh, Cells
from cases.geometry.meshes.reading import read_facets
from cases.geometry.meshes.repair import repaired

from .written import bag, corners, signed_volume

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def read(folder: Path, name: str, held: str | bytes) -> FacetMesh:
    path = folder / name
    path.write_bytes(held if isinstance(held, bytes) else held.encode())
    return read_facets(path)


def cells(kind: str, points: np.ndarray, *rows: list[int]) -> CellMesh:
    return CellMesh(np.asarray(points, float), [Cells(kind, np.array(rows), np.arange(len(rows)))])


def area(facets: FacetMesh) -> np.ndarray:
    a, b, c = (facets.points[facets.triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)[:, 2] / 2


def test_quads_split_along_the_shorter_diagonal() -> None:
    lean = SQUARE + np.array([[0, 0, 0], [0, 0, 0], [0.5, 0, 0], [0.5, 0, 0]])
    assert faceted(cells("quad", SQUARE, [0, 1, 2, 3])).triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert faceted(cells("quad", lean, [0, 1, 2, 3])).triangles.tolist() == [[1, 2, 3], [1, 3, 0]]
    for degenerate in ([0, 1, 2, 2], [0, 0, 1, 2], [0, 1, 1, 2], [0, 1, 2, 0]):
        (triangle,) = faceted(cells("quad", SQUARE, degenerate)).triangles.tolist()
        k = triangle.index(0)
        assert triangle[k:] + triangle[:k] == [0, 1, 2]


def test_polygons_are_cut_inside() -> None:
    """A star: a fan would leave it."""
    t = np.pi * np.arange(10) / 5
    r = np.where(np.arange(10) % 2, 0.3, 1.0)
    star = np.stack([r * np.cos(t), r * np.sin(t), 0 * t], axis=1)
    for turned in (range(10), range(9, -1, -1)):
        mesh = faceted(cells("polygon", star, list(turned)))
        areas = area(mesh)
        assert len(areas) == 8
        assert np.all(areas * areas.sum() > 0)
        assert abs(areas.sum()) == pytest.approx(5 * 0.3 * np.sin(np.pi / 5))
    with pytest.raises(MeshError, match="a face of 501 corners"):
        faceted(cells("polygon", np.zeros((501, 3)), list(range(501))))


@pytest.mark.parametrize(
    ("kind", "nodes"),
    [("tetra", 4), ("pyramid", 5), ("wedge", 6), ("hexahedron", 8)],
)
def test_solids_give_their_boundary(kind: str, nodes: int) -> None:
    """Outward as they stand, and closed."""
    corners = {
        "tetra": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "pyramid": [*SQUARE, [0.5, 0.5, 1]],
        "wedge": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
        "hexahedron": [*SQUARE, *(SQUARE + np.array([0, 0, 1]))],
    }[kind]
    mesh = faceted(cells(kind, np.array(corners), list(range(nodes))))
    volume = {"tetra": 1 / 6, "pyramid": 1 / 3, "wedge": 1 / 2, "hexahedron": 1.0}[kind]
    assert signed_volume(mesh) == pytest.approx(volume)
    assert signed_volume(repaired(mesh)) == pytest.approx(volume)
    assert not any("turned" in note for note in repaired(mesh).notes)
    assert f"boundary taken of the solids (1 {kind})" in mesh.notes


def test_second_order_cells_keep_their_middles() -> None:
    """Nodes on a paraboloid: each middle is where the surface is."""

    def lifted(plane: np.ndarray) -> np.ndarray:
        return np.column_stack([plane, plane[:, 0] ** 2 - plane[:, 1] ** 2])

    corner = SQUARE[:, :2]
    middle = (corner + np.roll(corner, -1, axis=0)) / 2
    quad = lifted(np.concatenate([corner, middle, [[0.5, 0.5]]]))
    triangle = lifted(np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]))
    for kind, points in (("triangle6", triangle), ("quad8", quad[:8]), ("quad9", quad)):
        mesh = faceted(cells(kind, points, list(range(len(points)))))
        assert mesh.middles is not None
        assert len(mesh.points) == (3 if kind == "triangle6" else 4)
        ends = mesh.points[mesh.triangles][:, :, :2]
        expected = lifted(((ends + np.roll(ends, -1, axis=1)) / 2).reshape(-1, 2)).reshape(-1, 3, 3)
        assert np.abs(mesh.middles - expected).max() < 1e-15, kind


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(
    ("form", "name"), [("gmsh22", "a.msh"), ("gmsh", "a.msh"), ("vtk", "a.vtk"), ("vtu", "a.vtu"),
                       ("abaqus", "a.inp"), ("nastran", "a.bdf")]
)  # fmt: skip
def test_second_order_triangles_from_files(form: str, name: str, tmp_path: Path) -> None:
    import meshio

    given = bag()
    ends = given.points[given.triangles]
    middles = (ends + np.roll(ends, -1, axis=1)) / 2 + [0, 0, 0.25]
    points = np.concatenate([given.points, middles.reshape(-1, 3)])
    more = len(given.points) + np.arange(middles.size // 3).reshape(-1, 3)
    nodes = np.concatenate([given.triangles, more], axis=1)
    meshio.Mesh(points, [("triangle6", nodes)]).write(tmp_path / name, file_format=form)
    mesh = read_facets(tmp_path / name)
    assert mesh.middles is not None
    assert np.array_equal(mesh.points[mesh.triangles], ends)
    assert np.array_equal(mesh.middles, middles)
    assert len(repaired(mesh).points) == len(given.points)


def test_obj_names_and_continued_lines(tmp_path: Path) -> None:
    text = (
        "o Bag\nv 0 0 0\nv 1 0 0 # a point\nv 1 1 0 1.0\nv 0 1 0 .5 .5 .5\nusemtl film\n"
        "g left sewn\nf 1 2 \\\n3\ng right\nusemtl Bag\nf 1/1 3/2 4/3\nl 1 2\n"
    )
    mesh = read(tmp_path, "a.obj", text)
    assert {name: own.tolist() for name, own in mesh.groups.items()} == {
        "Bag": [0, 1], "left": [0], "sewn": [0], "film": [0], "right": [1], "Bag (material)": [1],
    }  # fmt: skip
    assert "1 lines left out" in mesh.notes


@pytest.mark.parametrize("order", ["<", ">"])
def test_ply_of_either_order_with_uneven_faces(order: str, tmp_path: Path) -> None:
    name = {"<": "little", ">": "big"}[order]
    header = (
        f"ply\nformat binary_{name}_endian 1.0\nelement camera 1\nproperty list uchar float look\n"
        "element vertex 4\nproperty uchar red\nproperty double z\nproperty double y\n"
        "property float x\nelement face 2\nproperty short part\n"
        "property list ushort uint vertex_indices\nend_header\n"
    )
    body = struct.pack(f"{order}B2f", 2, 1.0, 2.0)
    for x, y, z in SQUARE:
        body += struct.pack(f"{order}Bddf", 9, z, y, x)
    body += struct.pack(f"{order}hH4I", 5, 4, 0, 1, 2, 3) + struct.pack(
        f"{order}hH3I", 6, 3, 0, 2, 1
    )
    mesh = read(tmp_path, "a.ply", header.encode() + body)
    assert np.array_equal(mesh.points, SQUARE)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 1]]
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {"part 5": [0, 1], "part 6": [2]}
    assert "left out: red, camera" in mesh.notes


def test_off_with_colours_on_one_line(tmp_path: Path) -> None:
    text = "COFF 4 2 0 # head\n0 0 0 255 0 0 1\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 0.5 0.5 0.5\n3 0 2 3\n"
    mesh = read(tmp_path, "a.off", text)
    assert np.array_equal(mesh.points, SQUARE)
    assert "colours of 1 faces left out" in mesh.notes


def test_gmsh_names_of_two_dimensions(tmp_path: Path) -> None:
    text = (
        '$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 "rim"\n2 1 "the film"\n'
        "$EndPhysicalNames\n$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n$EndNodes\n"
        "$Elements\n3\n1 1 2 1 1 10 20\n2 2 2 1 1 10 20 30\n3 2 2 7 1 10 30 40\n$EndElements\n"
    )
    mesh = read(tmp_path, "a.msh", text)
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {"the film": [0], "physical 7": [1]}
    assert "groups without triangles left out: 'rim' (1 cells)" in mesh.notes
    assert "cells left out: 1 line" in mesh.notes
    assert np.array_equal(mesh.points, SQUARE)


def test_vtk_polygons_and_fields(tmp_path: Path) -> None:
    text = (
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
        "0 0 0 1 0 0\n1 1 0 0 1 0\nPOLYGONS 2 9\n4 0 1 2 3\n3 0 2 1\nCELL_DATA 2\n"
        "SCALARS part int 1\nLOOKUP_TABLE default\n3 4\nFIELD more 1\nheat 1 2 double\n.5 .25\n"
    )
    mesh = read(tmp_path, "a.vtk", text)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 1]]
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {"part 3": [0, 1], "part 4": [2]}
    assert "cell data left out: heat" in mesh.notes


def piece(points: np.ndarray, at: int) -> tuple[str, bytes]:
    """One triangle of a raw appended file."""
    arrays = [
        (points.astype("<f8").tobytes(), 'type="Float64" NumberOfComponents="3"', "Points"),
        (np.arange(3).astype("<i8").tobytes(), 'type="Int64" Name="connectivity"', "Cells"),
        (np.array([3], "<i8").tobytes(), 'type="Int64" Name="offsets"', ""),
        (np.array([5], "u1").tobytes(), 'type="UInt8" Name="types"', ""),
    ]
    tags, held = [], b""
    for data, head, _ in arrays:
        tags.append(f'<DataArray {head} format="appended" offset="{at + len(held)}"/>')
        held += struct.pack("<Q", len(data)) + data
    text = f'<Piece NumberOfPoints="3" NumberOfCells="1"><Points>{tags[0]}</Points>'
    return f"{text}<Cells>{''.join(tags[1:])}</Cells></Piece>", held


def test_vtu_of_several_pieces_with_raw_data(tmp_path: Path) -> None:
    """A general library keeps the last piece only."""
    one, first = piece(SQUARE[[0, 1, 2]], 0)
    two, second = piece(SQUARE[[0, 2, 3]], len(first))
    head = '<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" header_type="UInt64">'
    text = f'{head}<UnstructuredGrid>{one}{two}</UnstructuredGrid><AppendedData encoding="raw">\n_'
    mesh = read(tmp_path, "a.vtu", text.encode() + first + second + b"\n</AppendedData></VTKFile>")
    assert np.array_equal(mesh.points[mesh.triangles], SQUARE[[[0, 1, 2], [0, 2, 3]]])


def test_vtp_polygons(tmp_path: Path) -> None:
    text = (
        '<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="4" NumberOfPolys="1">'
        '<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0 1 0 0 1 1 0 0 1 0'
        '</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity">0 1 2 3'
        '</DataArray><DataArray type="Int32" Name="offsets">4</DataArray></Polys></Piece>'
        "</PolyData></VTKFile>"
    )
    assert read(tmp_path, "a.vtp", text).triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_abaqus_sets_parts_and_quads(tmp_path: Path) -> None:
    text = (
        "*HEADING\n*PART, NAME=one\n*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1.\n4, 0., 1., 0.\n"
        "*ELEMENT, TYPE=S4R,\nELSET=Film\n1, 1, 2, 3, 4\n*ELSET, ELSET=all, GENERATE\n1, 9, 1\n"
        "*END PART\n*PART, NAME=two\n*NODE\n1, 0., 0., 1.\n2, 1., 0., 1.\n3, 1., 1., 1.\n"
        "*ELEMENT, TYPE=M3D3, ELSET=Inlet\n1, 1, 2,\n3\n*ELEMENT, TYPE=T3D2\n2, 1, 2\n*END PART\n"
        "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=one-1, PART=one\n*END INSTANCE\n"
        "*INSTANCE, NAME=two-1, PART=two\n*END INSTANCE\n"
        "*ELSET, ELSET=both, INSTANCE=two-1\n1,\n*ELSET, ELSET=both, INSTANCE=one-1\nfilm,\n"
        "*END ASSEMBLY\n"
    )
    mesh = read(tmp_path, "a.inp", text)
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {
        "Film": [0, 1], "all": [0, 1], "Inlet": [2], "both": [0, 1, 2], "one": [0, 1], "two": [2],
    }  # fmt: skip
    assert np.all(mesh.points[mesh.triangles[2], 2] == 1)
    moved = text.replace("PART=two\n*END INSTANCE", "PART=two\n0., 0., 5.\n*END INSTANCE")
    with pytest.raises(MeshError, match="instance 'two-1' is moved"):
        read(tmp_path, "b.inp", moved)


@pytest.mark.parametrize(
    "name",
    ["$ Femap Property 3 : the film", '$HMNAME PROP  3"the film" 4', '$HMNAME COMP   3"the film"',
     "$ANSA_NAME;3;PSHELL;the film", "$ Elements and Element Properties for region : the film",
     "$* Property: the film", "$* Property: 3 name: the film", "$ANSA_NAME;3;PSHELL;~\n$the film",
     "$ANSA_NAME_COMMENT;3;PSHELL;the film;;NO;NO;", '$HMNAME COMP 8 "the film" 3 "cloth" 4',
     '$HMNAME COMP 3"other"\n$HMNAME PROP 3"the film" 4'],
)  # fmt: skip
def test_nastran_names_numbers_and_continuations(name: str, tmp_path: Path) -> None:
    text = (
        f"{name}\nPSHELL,3,1,.1\nGRID    {1:8d}{'':8s}{'0.':>8s}{'0.':>8s}{'0.':>8s}\n"
        f"GRID,2,,1.,0.,0.\nGRID*   {3:16d}{'':16s}{'1.+0':>16s}{'1.D0':>16s}\n"
        f"*       {'0.0':>16s}\nGRID    {4:8d}{'':8s}{'0.':>8s}{'10.-1':>8s}\n"
        f"CQUAD4  {1:8d}{3:8d}{1:8d}{2:8d}{3:8d}{4:8d}\nCTRIA3,2,9,1,3,2\n"
        "CBAR,3,1,1,2,0.,0.,1.\nENDDATA\nrubbish\n"
    )
    mesh = read(tmp_path, "a.nas", text)
    assert np.array_equal(mesh.points, SQUARE)
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {
        "the film": [0, 1],
        "property 9": [2],
    }
    assert "1 CBAR left out" in mesh.notes


def test_lsdyna_cards(tmp_path: Path) -> None:
    text = (
        "*KEYWORD\n*TITLE\nbag\n*NODE\n$   nid               x\n"
        "       1             0.0             0.0             0.0       0       0\n"
        "2,1.,0.,0.\n*NODE %\n         3             1.0             1.0             0.0\n*NODE+\n"
        "                   4                 0.0                 1.0                 0.0\n"
        "*PART_CONTACT\nthe film\n         5         1\n       0.0\n"
        "*PART\ninlet\n         6         1\n"
        "*ELEMENT_SHELL_THICKNESS\n       1       5       1       2       3       4\n"
        "             0.1             0.1             0.1             0.1\n"
        "*ELEMENT_SHELL\n       2       6       1       3       2       2\n"
        "*ELEMENT_BEAM\n       9       1       1       2\n"
        "*SET_SHELL_LIST_TITLE\nseam\n         1\n         1         2\n"
        "*SET_SHELL_LIST_GENERATE\n         7\n         2         9\n*END\nrubbish\n"
    )
    mesh = read(tmp_path, "a.k", text)
    assert np.array_equal(mesh.points, SQUARE)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 1]]
    assert {k: v.tolist() for k, v in mesh.groups.items()} == {
        "the film": [0, 1], "inlet": [2], "seam": [0, 1, 2], "set 7": [2],
    }  # fmt: skip
    assert "1 lines of *ELEMENT_BEAM left out" in mesh.notes


def test_many_names_of_one_group_join(tmp_path: Path) -> None:
    """Solids of one name in turn are one group."""
    given = bag()
    facet = "facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n"
    rows = [
        facet.format(*(" ".join(map(repr, point)) for point in triangle))
        for triangle in given.points[given.triangles].tolist()
    ]
    names = ["film", "inlet", "film", "SOLID"]
    text = "".join(
        f"solid {name}\n{''.join(rows[i::4])}endsolid {name}\n" for i, name in enumerate(names)
    )
    mesh = read(tmp_path, "a.stl", text)
    assert {k: len(v) for k, v in mesh.groups.items()} == {"film": 40, "inlet": 20, "SOLID": 20}
    assert np.array_equal(corners(mesh), corners(given))


def test_lsdyna_numbers_that_touch_or_do_not_fit(tmp_path: Path) -> None:
    """Wide numbers (I10), coordinates without blanks, columns that are not the format's."""
    node = "*KEYWORD I10=Y\n*NODE\n" + "".join(
        f"{1234567891 + i:10d}{x:16.9E}{y:16.9E}{z:16.9E}\n"
        for i, (x, y, z) in enumerate(SQUARE - 2)
    )
    shell = "*ELEMENT_SHELL\n" + "".join(f"{1234567891 + k:10d}" for k in (0, 0, 0, 1, 2, 3))
    mesh = read(tmp_path, "a.k", f"{node}{shell}\n*END\n")
    assert np.array_equal(mesh.points, SQUARE - 2)
    wide = "*KEYWORD\n*NODE\n" + "".join(
        f"{12345678 + i:10d}{x:20.9g}{y:20.9g}{z:20.9g}\n" for i, (x, y, z) in enumerate(SQUARE)
    )
    shell = "*ELEMENT_SHELL\n" + " ".join(str(12345678 + k) for k in (0, 0, 0, 1, 2, 3))
    mesh = read(tmp_path, "b.k", f"{wide}{shell}\n*END\n")
    assert np.array_equal(mesh.points, SQUARE)
