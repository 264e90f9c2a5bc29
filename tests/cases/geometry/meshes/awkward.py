"""Broken and awkward mesh files, and what each is answered with.

A table for all who read files: `AWKWARD[name]` makes a file in a folder and says whether it is
refused, by one line that matches, or mended, with a note that matches.
"""

from __future__ import annotations

import gzip
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cases.geometry.meshes.facet_mesh import FacetMesh

from .written import (
    abaqus_text,
    bag,
    by_meshio,
    lsdyna_text,
    nastran_text,
    obj_text,
    off_text,
    ply_text,
    soup,
    stl_binary,
    stl_text,
)


@dataclass(frozen=True)
class Awkward:
    """A file: its name, what makes its bytes, and the answer (a pattern)."""

    file: str
    make: Callable[[], bytes | str]
    answer: str
    mended: bool = False

    def written(self, folder: Path) -> Path:
        path, held = folder / self.file, self.make()
        path.write_bytes(held if isinstance(held, bytes) else held.encode())
        return path


def _binary() -> bytes:
    return stl_binary(bag().points, bag().triangles)


def _flipped() -> bytes:
    """A third of the triangles the other way round, points off by 1e-7."""
    rng = np.random.default_rng(5)
    given = soup(bag(2))
    turned = rng.random(len(given.triangles)) < 1 / 3
    triangles = np.where(turned[:, None], given.triangles[:, ::-1], given.triangles)
    points = given.points + rng.uniform(-1e-7, 1e-7, given.points.shape)
    return stl_binary(points, triangles)


def _inward() -> bytes:
    return stl_binary(bag().points, bag().triangles[:, ::-1])


def _twice() -> str:
    text = stl_text(bag())
    return text + text


def _without_last(text: str, lines: int = 1) -> str:
    return "\n".join(text.splitlines()[:-lines]) + "\n"


def _swap(make: Callable[[FacetMesh], str], old: str, new: str, count: int = 1) -> str:
    text = make(bag())
    assert old in text, old
    return text.replace(old, new, count)


def _moebius(half_turns: int = 1, n: int = 12) -> str:
    t = 2 * np.pi * np.arange(n) / n
    lines, after = ["OFF", f"{2 * n} {2 * n} 0"], (np.arange(n) + 1) % n
    for s in (-0.3, 0.3):
        r = 1 + s * np.cos(half_turns * t / 2)
        rows = np.stack([r * np.cos(t), r * np.sin(t), s * np.sin(half_turns * t / 2)], axis=1)
        lines += [" ".join(f"{x:.9f}" for x in row) for row in rows]
    for i in range(n):
        c, d = (after[i], after[i] + n) if after[i] else (n, 0)
        lines += [f"3 {i} {c} {i + n}", f"3 {i + n} {c} {d}"]
    return "\n".join(lines) + "\n"


def _tether() -> str:
    given = bag()
    a, b, _ = given.triangles[0] + 1
    return obj_text(given) + f"v 0 0 0\ng tether\nf {a} {b} {len(given.points) + 1}\n"


def _two_bags() -> str:
    given = bag()
    points = np.concatenate([given.points, given.points + np.array([5.0, 0, 0])])
    triangles = np.concatenate([given.triangles, given.triangles + len(given.points)])
    return off_text(FacetMesh(points, triangles))


def _quads() -> str:
    """A box of six faces of four corners, one of them with five."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["v 0.5 0 1"]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 9 2", "3 4 8 7", "2 9 6 8 4", "1 3 7 5"]
    return "\n".join(lines + [f"f {face}" for face in faces]) + "\n"


def _relative() -> str:
    lines = []
    for triangle in bag().points[bag().triangles]:
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
        lines.append("f -3/-1/-1 -2//-1 -1")
    return "\n".join([*lines[:1], "vt 0 0", "vn 0 0 1", *lines[1:]]) + "\n"


def _solid(form: str) -> bytes:
    """Two tetrahedra that share a face, alone in a file."""
    import tempfile

    import meshio

    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    mesh = meshio.Mesh(points, [("tetra", [[0, 1, 2, 3], [1, 2, 3, 4]])])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file"
        mesh.write(path, file_format=form)
        return path.read_bytes()


def _meshio(form: str, **options: object) -> bytes:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file"
        by_meshio(bag(), path, form, **options)
        return path.read_bytes()


def _vtu(old: str, new: str, count: int = 1) -> str:
    text = _meshio("vtu", binary=False).decode()
    assert old in text, old
    return text.replace(old, new, count)


def _entities() -> str:
    """A billion laughs."""
    lines = ['<?xml version="1.0"?>', "<!DOCTYPE VTKFile [", '<!ENTITY a "ha">']
    lines += [
        f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True)
    ]
    return "\n".join([*lines, "]>", '<VTKFile type="UnstructuredGrid">&i;</VTKFile>'])


def _bomb() -> bytes:
    """A block that declares 4 GiB."""
    import base64
    import zlib

    block = zlib.compress(b"\0" * 1_000_000)
    head = np.array([1, 2**32 - 1, 0, len(block)], "<u4").tobytes()
    held = (base64.b64encode(head) + base64.b64encode(block)).decode()
    return (
        '<VTKFile type="UnstructuredGrid" compressor="vtkZLibDataCompressor"><UnstructuredGrid>'
        '<Piece NumberOfPoints="3" NumberOfCells="1"><Points><DataArray type="Float64" '
        f'NumberOfComponents="3" format="binary">{held}</DataArray></Points></Piece>'
        "</UnstructuredGrid></VTKFile>"
    ).encode()


def _ply_header(count: int) -> bytes:
    """A header that counts more faces than any file holds."""
    lines = ["ply", "format binary_little_endian 1.0", "element vertex 3"]
    lines += [f"property float {k}" for k in "xyz"]
    lines += [f"element face {count}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(lines).encode() + b"\0" * 36


def _flat_deck(own: bool) -> str:
    """Two flat sheets that lie on each other: sewn along the rim, or on the same nodes."""
    n = 4
    node = "\n".join(
        f"{1 + s * 100 + (n + 1) * i + j:8d}{i:16.1f}{j:16.1f}{0:16.1f}"
        for s in range(1 + own)
        for i in range(n + 1)
        for j in range(n + 1)
    )
    lines = ["*KEYWORD", "*PART", "Airbag 1", f"{1:10d}", "Airbag 2", f"{2:10d}", "*NODE", node]
    lines.append("*ELEMENT_SHELL")
    for s in range(2):
        for i in range(n):
            for j in range(n):
                a = 1 + s * 100 * own + (n + 1) * i + j
                row = (1 + s * 50 + n * i + j, 1 + s, a, a + n + 1, a + n + 2, a + 1)
                lines.append("".join(f"{word:8d}" for word in row))
    return "\n".join([*lines, "*END"]) + "\n"


def _edge(text: str) -> str:
    return text.rstrip("\n")


AWKWARD: dict[str, Awkward] = {
    # the file is none, or not what its name says
    "empty": Awkward("bag.stl", lambda: b"", "bag.stl: empty; export it again"),
    "only zeros": Awkward("bag.stl", lambda: b"\0" * 500, "bag.stl: empty; export it again"),
    "unknown ending": Awkward(
        "bag.3mf", lambda: b"PK", r"no reader for '.3mf'; save it as .*\.stl"
    ),
    "web page": Awkward(
        "bag.stl", lambda: "<!DOCTYPE html><html></html>", "no mesh but a web page"
    ),
    "zip": Awkward("bag.obj", lambda: b"PK\x03\x04" + b"x" * 99, "a zip archive; unpack it"),
    "gzip": Awkward("bag.ply", lambda: gzip.compress(b"ply"), "a gzip archive; unpack it"),
    "numpy array": Awkward("bag.stl", lambda: b"\x93NUMPY\x01\0v", "no mesh but an array of numpy"),
    "git-lfs pointer": Awkward(
        "bag.ply", lambda: "version https://git-lfs.github.com/spec/v1\n", "a pointer of git-lfs"
    ),
    "OBJ named STL": Awkward("bag.stl", lambda: obj_text(bag()), "not an STL file: neither"),
    "STL named OBJ": Awkward("bag.obj", lambda: stl_text(bag()), "line 1: 'solid' is no word of"),
    "binary named OBJ": Awkward("bag.obj", _binary, r"binary data at byte \d+, text is expected"),
    "Fluent named Gmsh": Awkward("bag.msh", lambda: '(0 "mesh")\n(2 3)\n', "not a Gmsh mesh"),
    # STL
    "scrambled header": Awkward("bag.stl", _binary, "240 points welded to 42", mended=True),
    "unwelded and flipped": Awkward(
        "bag.stl", _flipped, r"\d+ of 320 triangles turned", mended=True
    ),
    "inward": Awkward("bag.stl", _inward, "80 of 80 triangles turned", mended=True),
    "exported twice": Awkward(
        "bag.stl", _twice, r"80 doubled triangles dropped, the first at \(", mended=True
    ),
    "binary STL cut short": Awkward(
        "bag.stl", lambda: _binary()[:-120], "80 triangles by its header, room for 77.6 in the file"
    ),
    "binary STL with a tail": Awkward(
        "bag.stl", lambda: _binary() + b"tail", "4 bytes after the last facet", mended=True
    ),
    "text STL cut short": Awkward(
        "bag.stl", lambda: stl_text(bag())[:-700], "without 'endsolid': cut short"
    ),
    "facet without a vertex": Awkward(
        "bag.stl",
        lambda: "\n".join(stl_text(bag()).splitlines()[:10] + stl_text(bag()).splitlines()[11:]),
        "facet 2 of the solid at line 1 is not",
    ),
    "not a number": Awkward(
        "bag.stl",
        lambda: _swap(stl_text, "vertex -0.53125", "vertex nan"),
        r"coordinates of point \d+ are \[nan, .*not finite",
    ),
    "infinite": Awkward(
        "bag.inp", lambda: _swap(abaqus_text, "\n7, ", "\n7, inf, "), r"point 7 are \[inf, .*mend"
    ),
    # OBJ
    "relative indices": Awkward("bag.obj", _relative, "240 points welded to 42", mended=True),
    "vertex zero": Awkward(
        "bag.obj", lambda: obj_text(bag()) + "f 0 1 2\n", r"line \d+: a face names vertex 0"
    ),
    "vertex beyond": Awkward(
        "bag.obj", lambda: obj_text(bag()) + "f 1 2 99\n", "a face names vertex 99, the file has 42"
    ),
    "quads and polygons": Awkward("box.obj", _quads, "2 polygons of 5 corners cut", mended=True),
    "no line end": Awkward(
        "bag.obj", lambda: _edge(obj_text(bag())), "nothing tells whether the file is whole", True
    ),
    "point cloud": Awkward(
        "bag.obj", lambda: "v 0 0 0\nv 1 0 0\n", "no triangles in it but no cells"
    ),
    "inner wall": Awkward(
        "bag.obj", _tether, r"1 edges of three or more .* from \(.*\) to \(.*with 3 of .*tether"
    ),
    "a face missing": Awkward(
        "bag.obj", lambda: _without_last(obj_text(bag())), "79 triangles", mended=True
    ),
    # topology
    "Moebius": Awkward("bag.off", _moebius, r"24 triangles has one side only .* edge from \("),
    "two bags": Awkward("bag.off", _two_bags, "2 components: 80 triangles, area", mended=True),
    "all at one point": Awkward(
        "bag.off",
        lambda: "OFF 3 1 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n",
        "all of its triangles are collapsed",
    ),
    "all on one line": Awkward(
        "bag.off",
        lambda: "OFF 4 2 0\n0 0 0\n1 0 0\n2 0 0\n4 0 0\n3 0 1 2\n3 1 2 3\n",
        r"no triangle of it has a height, the first lies at \(1, 0, 0\)",
    ),
    "needles of a CAD program": Awkward(
        "bag.off",
        lambda: (
            "OFF 5 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0 0\n3 0 4 3\n3 4 1 2\n3 4 2 3\n3 0 1 4\n"
        ),
        "1 triangles without height turned",
        mended=True,
    ),
    # counted formats
    "OFF cut short": Awkward(
        "bag.off", lambda: _without_last(off_text(bag()), 3), "42 vertices and 80 faces, 119 lines"
    ),
    "OFF corner beyond": Awkward(
        "bag.off", lambda: _without_last(off_text(bag())) + "3 0 1 42\n", "a corner beyond the 42"
    ),
    "PLY cut short": Awkward("bag.ply", lambda: ply_text(bag())[:-90], r"element face.*cut short"),
    "PLY of a corner and a half": Awkward(
        "bag.ply",
        lambda: _swap(ply_text, "\n3 9 ", "\n3 9.5 "),
        "element face 0?.*: .*not all are numbers|a number that should be whole is not",
    ),
    "Gmsh of a node and a half": Awkward(
        "bag.msh",
        lambda: _meshio("gmsh22", binary=False).replace(b"\n42 ", b"\n42.5 ", 1),
        "nodes: a number that should be whole is not",
    ),
    "PLY that counts 4e9": Awkward(
        "bag.ply", lambda: _ply_header(4_000_000_000), "header counts 4000000000, more than"
    ),
    "PLY of points": Awkward(
        "bag.ply",
        lambda: (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n0 0 0\n"
        ),
        r"no faces \(vertex_indices\); a point cloud has no surface",
    ),
    "Gmsh cut short": Awkward(
        "bag.msh",
        lambda: _meshio("gmsh22", binary=False)[:-300],
        r"section \$Elements is not closed: cut short",
    ),
    "Gmsh without nodes": Awkward(
        "bag.msh",
        lambda: _meshio("gmsh22", binary=False).replace(b"\n42 ", b"\n942 ", 1),
        "a cell names point 42, which the file has not",
    ),
    "tetrahedra": Awkward(
        "bag.msh",
        lambda: _solid("gmsh22"),
        r"boundary taken of the solids \(2 tetra\)",
        mended=True,
    ),
    "VTK lines": Awkward(
        "bag.vtk",
        lambda: (
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
            "0 0 0 1 0 0\nLINES 1 3\n2 0 1\n"
        ),
        "no triangles in it but 1 line; export a surface",
    ),
    "VTK volume image": Awkward(
        "bag.vtk",
        lambda: (
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
        ),
        "data set 'STRUCTURED_POINTS': save an unstructured grid",
    ),
    "VTK cut short": Awkward(
        "bag.vtk", lambda: _meshio("vtk42", binary=True)[:900], "before all of|cut short|damaged"
    ),
    "VTU with entities": Awkward("bag.vtu", _entities, "declares entities"),
    "VTU that unpacks to 4 GiB": Awkward("bag.vtu", _bomb, "unpacks to 4294967295 bytes"),
    "VTU cut short": Awkward(
        "bag.vtu", lambda: _vtu("", "", 0)[:-60], "its XML ends or breaks: .*line"
    ),
    "VTU that miscounts": Awkward(
        "bag.vtu",
        lambda: _vtu('NumberOfCells="80"', 'NumberOfCells="79"'),
        "a <Piece> of 79 cells holds 80",
    ),
    # decks
    "Abaqus membranes": Awkward(
        "bag.inp", lambda: abaqus_text(bag()), "80 triangles, 42 points, 2 groups", mended=True
    ),
    "Abaqus of unknown elements": Awkward(
        "bag.inp",
        lambda: abaqus_text(bag(), "XYZ3"),
        "no triangles in it but 80 element XYZ3; export a surface",
    ),
    "Abaqus that includes": Awkward(
        "bag.inp", lambda: "*INCLUDE, INPUT=/etc/passwd\n", r"\*INCLUDE is not read; put its text"
    ),
    "Abaqus without a node": Awkward(
        "bag.inp", lambda: _swap(abaqus_text, "\n42, ", "\n43, "), "names node 42, which the file"
    ),
    "Nastran in another system": Awkward(
        "bag.nas",
        lambda: "GRID,1,5,0.,0.,0.\n",
        "line 1: a point in system 5; export basic ones",
    ),
    "Nastran without an end": Awkward(
        "bag.bdf", lambda: _without_last(nastran_text(bag())), "no ENDDATA at its end", mended=True
    ),
    "LS-DYNA of two flat sheets": Awkward(
        "bag.k", lambda: _flat_deck(True), "50 points welded to 34", mended=True
    ),
    "LS-DYNA sheets on the same nodes": Awkward(
        "bag.k",
        lambda: _flat_deck(False),
        r"32 triangles on the same three points in different groups \('Airbag 1' and 'Airbag 2'\)",
    ),
    "LS-DYNA that includes": Awkward(
        "bag.k", lambda: "*KEYWORD\n*INCLUDE\nmesh.k\n", r"line 2: \*INCLUDE is not read"
    ),
    "LS-DYNA encrypted": Awkward(
        "bag.key",
        lambda: "*KEYWORD\n-----BEGIN PGP MESSAGE-----\nabc\n",
        "line 2: encrypted from here on",
    ),
    "LS-DYNA with a bare star": Awkward(
        "bag.k", lambda: lsdyna_text(bag()) + "*\n", "80 triangles", mended=True
    ),
    "LS-DYNA with a parameter": Awkward(
        "bag.k",
        lambda: "*KEYWORD\n*NODE\n       1           &size             0.0             0.0\n",
        "line 3: '&size' is no number",
    ),
}


def unfolded_deck(facets: FacetMesh) -> str:
    """A deck with a reference geometry of twice the size."""
    return lsdyna_text(replace(facets), 2 * facets.points)
